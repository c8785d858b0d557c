"""Some runs of the line as recordings, taken in and calibrated as every run is."""

from collections import Counter
from dataclasses import dataclass, field

from schemas.recording import Manifest, Recording
from schemas.tolerance import Tolerance
from storage.catalogue import runs
from storage.home import Home
from tasks.conformity import decide
from tasks.stages.estimate import estimate
from tests.proof.line.draw import BEGINNING, YEAR_D, YEARS, Line, LineUnit, is_tilted, station_name
from tests.proof.line.papers import manifest_of_run
from tests.proof.line.physics import case_of, played
from tests.proof.line.visits import LineRun

PERIODS = 8  # of the years, each with a recording of each station
OF_A_UNIT = 2


@dataclass
class Recorded:
    """Which runs have a recording: one of each station in each period, two of a unit at most.

    most: how many there may be. found: how many there are of each station and period.
    """

    most: int
    found: Counter[tuple[int, int]] = field(default_factory=Counter)
    of_units: Counter[int] = field(default_factory=Counter)

    def takes(self, run: LineRun) -> bool:
        """Whether a run is to have one, which is counted then."""
        period = int(PERIODS * (run.at - BEGINNING).days / (YEARS * YEAR_D))
        cell = (run.station, period)
        is_full = self.found.total() >= self.most or self.of_units[run.unit] >= OF_A_UNIT
        if run.attempt or is_full or self.found[cell]:
            return False
        self.found[cell] += 1
        self.of_units[run.unit] += 1
        return True


def as_recorded(
    line: Line, unit: LineUnit, run: LineRun, tolerance: Tolerance, recorded: Recorded, home: Home
) -> LineRun:
    """The run as it is, or with the real result of a recording that was taken in."""
    if run.calibration.validity.verdict == "invalid" or not recorded.takes(run):
        return run
    taken, _ = runs.add(recording_of(line, unit, run), home)
    calibration = estimate(taken, home)
    decision = decide(calibration, tolerance)
    return run.model_copy(update={"calibration": calibration, "decision": decision})


def recording_of(line: Line, unit: LineUnit, run: LineRun) -> Recording:
    """The run as the plant plays it, with its unit's coefficients of that day."""
    tilt = line.tilt if is_tilted(line, run.station, run.at) else None
    case = case_of(line.seed * 100_000 + 100 * unit.number + run.number, unit.grade, tilt)
    recording = played(case, unit.after(run.years, run.kept))
    declared = recording.manifest.model_dump(mode="json", exclude_none=True)
    declared |= manifest_of_run(unit, run)
    declared["station"]["id"] = station_name(run.station)
    return Recording(
        Manifest.model_validate(declared), recording.imu, recording.table, recording.environment
    )
