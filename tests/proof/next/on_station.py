"""Once on the virtual station: acquire, explain (several names), next, acquire, explain (one)."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from schemas.next_recording import NextRecording
from schemas.orders import NextOrder
from schemas.procedure import Procedure
from schemas.recording import Recording
from storage import settings
from storage.catalogue import runs
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import RawWriter
from storage.home import Home
from tasks.explain.explain import explain
from tasks.stages.next_recording import next_recording
from tasks.station.virtual.config import VirtualStation
from tests.proof.station.case import Case
from tests.proof.station.record import shortened
from tests.tasks.station.in_memory import InMemoryStation

SPEED = 200.0  # station seconds in a second of the simulated wall clock
SPREAD_M = 0.45e-3  # of the accelerometers about the intersection of the table's axes
UNIT, PLACES = 3, 9  # seeds
PAGE = "next-station.md"

TEXT = """# The recording that decides, on the virtual station

`make prove ARGS="--next-on-station {most:g}"`. Accelerometers at {places}
(mm, x, y, z each); nothing else that the standard leaves out but Earth's rotation. The truth is a
size effect.

1. `acquire` of JJF 2003's sequence with short dwells, {base:.1f} min; `explain` says: {first}.
2. `next --minutes {most:g}`: {sentence}
3. `acquire --procedure`, {seconds:.1f} min; `explain` says: {second}.
"""


@dataclass(frozen=True)
class Judged:
    """What `explain` says: the names of each finding, with those it cannot be told from."""

    names: tuple[tuple[str, ...], ...]

    def __str__(self) -> str:
        return "; ".join(" or ".join(each) for each in self.names) or "nothing"


def run_next_on_station(minutes: int, out: Path | None) -> None:
    """The page, in the folder `out`, else in proof-next-station. minutes: of the proposal."""
    folder = out or Path("proof-next-station")
    folder.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as work:
        text = _played(Path(work), minutes)
    (folder / PAGE).write_text(text, encoding="utf-8")
    print(text)


def _played(folder: Path, minutes: int) -> str:
    station = _station()
    first = _acquired(station, shortened("jjf2003"), folder / "first.mcap")
    home, out = Home(folder / "home"), folder / "next.json"
    run, _ = runs.add(first, home)
    order = NextOrder(runs=(run.id,), minutes=minutes, out=str(out))
    answer: NextRecording = next_recording([run], home, order)
    second = _acquired(station, settings.read(out, Procedure), folder / "second.mcap")
    return TEXT.format(
        places="; ".join(_millimetres(place) for place in station.unit.places_m),
        base=first.imu.t[-1] / 60.0, first=_response(first), most=minutes,
        sentence=answer.statement.en, seconds=second.imu.t[-1] / 60.0, second=_response(second),
    )  # fmt: skip


def _station() -> VirtualStation:
    """A unit without drift by temperature and without filters, its accelerometers apart."""
    station = Case(UNIT, "jjf2003", has_low_pass=False, has_delay=False).station
    places = np.random.default_rng(PLACES).normal(0.0, SPREAD_M, (3, 3)).tolist()
    steady = {
        name: getattr(station.unit, name).model_copy(update={"bias_per_kelvin": (0.0, 0.0, 0.0)})
        for name in ("gyro", "accel")
    }
    unit = station.unit.model_copy(update=steady | {"places_m": tuple(map(tuple, places))})
    return station.model_copy(update={"unit": unit})


def _acquired(station: VirtualStation, procedure: Procedure, path: Path) -> Recording:
    with RawWriter(path) as sink:
        InMemoryStation(station, SPEED).acquire(procedure, sink)
    return read_mcap(path)


def _response(recording: Recording) -> Judged:
    return Judged(
        tuple(
            tuple(dict.fromkeys((one.effect, *one.group, *one.indistinguishable)))
            for one in explain(recording).findings
        )
    )


def _millimetres(place: Sequence[float]) -> str:
    return ", ".join(f"{1e3 * each:.2f}" for each in place)
