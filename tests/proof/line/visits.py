"""A unit's visits to the line: run, run again where that did not end well, adjusted, certified."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from schemas.base import Frozen
from schemas.calibration import Calibration
from schemas.decision import Decision
from schemas.text import Remark
from schemas.tolerance import Tolerance
from tasks.conformity import decide
from tests.proof.line.draw import BEGINNING, STATIONS, YEAR_D, YEARS, Line, LineUnit, is_tilted
from tests.proof.line.physics import Measured, result_of
from tests.proof.plant.case import Grade

INVALID, MISSING = 0.03, 0.01  # of the runs
AGAIN_H = 26.0  # until a unit is run again
RETESTS = 0.9  # of the runs that did not end well
ADJUSTED_TO = 0.3  # of its errors that an adjustment leaves
SHOCK = Remark(
    code="table_disturbed", en="The table was disturbed while the unit was at rest.",
    zh="静止测量期间转台受到扰动。", blocks_pass=True, run="invalid",
)  # fmt: skip


class LineRun(Frozen):
    """One run. visit: the unit's how manyeth; attempt: 0 for the first of the visit. is_last: no
    other follows in the visit. adjusted: whether the unit was adjusted since the attempt before.
    kept, years: how its coefficients stood, as `LineUnit.after` has it.
    """

    unit: int
    number: int
    at: datetime
    station: int
    visit: int
    attempt: int
    adjusted: bool
    is_last: bool
    kept: float
    years: float
    calibration: Calibration
    decision: Decision


@dataclass
class _State:
    """How a unit stands between two runs."""

    kept: float
    since: float  # years at which it was adjusted last


def runs_of(
    line: Line, unit: LineUnit, measured: Mapping[Grade, Measured], tolerance: Tolerance
) -> Iterator[LineRun]:
    """A unit's runs from the oldest, as many as each unit of the line has."""
    rng = np.random.default_rng([line.seed, 62, unit.number])
    count = line.runs // len(line.units) + (unit.number < line.runs % len(line.units))
    pause = YEARS * YEAR_D * float(rng.uniform(0.86, 0.97)) / max(1, count)
    day, state, visit, made = float(rng.uniform(0.0, pause)), _State(1.0, 0.0), 0, 0
    while made < count:
        station = int(rng.integers(STATIONS))
        for one in _visit(line, unit, measured[unit.grade], tolerance, rng, state, day, station):
            is_last = one.is_last or made + 1 == count
            yield one.model_copy(update={"visit": visit, "number": made, "is_last": is_last})
            made += 1
            if made == count:
                break
        day, visit = day + pause * float(rng.uniform(0.6, 1.5)), visit + 1


def _visit(
    line: Line,
    unit: LineUnit,
    how: Measured,
    tolerance: Tolerance,
    rng: np.random.Generator,
    state: _State,
    day: float,
    station: int,
) -> Iterator[LineRun]:
    """Runs of one visit: at most three, the last of them after an adjustment."""
    adjusted = False
    for attempt in range(3):
        at = BEGINNING + timedelta(days=day, hours=AGAIN_H * attempt)
        kept, years = state.kept, (at - BEGINNING).days / YEAR_D - state.since
        truth = unit.after(years, kept)
        chance = rng.uniform()
        without = "gyro_g_sensitivity" if INVALID < chance < INVALID + MISSING else None
        result = result_of(unit, truth, how, is_tilted(line, station, at), rng, without)
        if chance < INVALID:
            result = result.model_copy(update={"remarks": (SHOCK,)})
        decision = decide(result, tolerance)
        well = decision.verdict == "pass"
        is_last = well or attempt == 2 or rng.uniform() > RETESTS
        yield LineRun(
            unit=unit.number, number=0, at=at, station=station, visit=0, attempt=attempt,
            adjusted=adjusted, is_last=is_last, kept=kept, years=years,
            calibration=result, decision=decision,
        )  # fmt: skip
        if is_last:
            return
        adjusted = attempt == 1 and decision.verdict == "fail"
        if adjusted:
            state.kept, state.since = ADJUSTED_TO, (at - BEGINNING).days / YEAR_D
