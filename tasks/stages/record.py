"""Stage: a recording comes into the store, from a station or from elsewhere."""

from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from schemas.base import Unusable
from schemas.procedure import Procedure
from schemas.recording import Recording
from schemas.station import StationFile
from storage import store
from storage.home import Home
from storage.raw import RawWriter, read_mcap
from storage.store import Run
from tasks.segments.check import wrong_rate_unit
from tasks.segments.summarise import summarise_all
from tasks.station.sequence import Acquired, Progress, acquire


def take_in(
    path: Path, home: Home, *, manifest: Path | None = None, salvage: bool = False
) -> tuple[Run, bool]:
    """A recording from elsewhere: read, check, keep. Returns the run and whether it is new.

    Raises Unusable, with the store unchanged, where the recording cannot be used.
    """
    known = None if manifest else store.known(path, home)
    if known is not None:
        return known, False
    recording = store.read(path, manifest=manifest, salvage=salvage)
    _refuse_wrong_units(recording, path)
    before = {run.id for run in store.runs(home)}
    run = store.keep(recording, home, source=None if manifest or salvage else path)
    return run, run.id not in before


def run_of(reference: str, home: Home) -> Run:
    """The run that a command names: an id, or a path that is taken in on the fly."""
    path = Path(reference)
    if path.exists():
        return take_in(path, home)[0]
    return store.find(reference, home)


def acquire_run(
    station: StationFile,
    procedure: Procedure,
    home: Home,
    report: Callable[[Progress], None],
) -> tuple[Run, Acquired]:
    """A run on a station: raw is written as it comes, then kept as a run.

    If the run breaks off, what was recorded stays in the home's `acquiring` folder as an MCAP
    file, and the sentence of Unusable says where.
    """
    began = datetime.now(UTC)
    recording_id = f"{station.unit.serial}-{procedure.name}-{began:%Y%m%dT%H%M%SZ}"
    folder = home.path / "acquiring"
    folder.mkdir(parents=True, exist_ok=True)
    raw = folder / f"{recording_id}.mcap"
    try:
        with RawWriter(raw) as sink:
            acquired = acquire(station, procedure, sink, report, recording_id=recording_id)
    except Unusable as fault:
        raise Unusable(f"{fault} Recorded so far: {raw} (mimucal import takes it in).") from fault
    run = store.keep(read_mcap(raw), home)
    raw.unlink()
    return run, acquired


def _refuse_wrong_units(recording: Recording, path: Path) -> None:
    rates = tuple(s for s in recording.manifest.segments or () if s.kind == "rate")
    fault = wrong_rate_unit(recording, summarise_all(recording, rates, "label"))
    if fault is not None:
        raise Unusable(f"{path}: {fault}")
