"""Stage: a run on a station; raw is written as it comes, then kept as a run."""

import secrets
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from schemas.base import BrokenOff, Unusable
from schemas.procedure import Procedure
from schemas.station import StationFile
from storage.catalogue import runs
from storage.catalogue.listing import Run
from storage.formats.mcap.reader import read_mcap
from storage.formats.mcap.writer import RawWriter
from storage.home import Home
from storage.station_lock import one_run_on
from storage.whole_files import writing_in_home
from tasks.stages.left_run import LeftRun, left_run
from tasks.stages.run_status import status_file
from tasks.stages.stage import stage
from tasks.station.acquisition import Acquired, RunRequest, acquire
from tasks.station.interrupted import Interrupted, interrupted
from tasks.station.ports import Ask
from tasks.station.progress import Progress


@stage("acquire", again=False)
def acquire_run(
    station: StationFile,
    procedure: Procedure,
    home: Home,
    report: Callable[[Progress], None],
    ask: Ask | None = None,
    is_paused: Callable[[], bool] = lambda: False,
    resume: bool = False,
) -> tuple[Run, Acquired]:
    """Acquire a run while no other is going on at the station; see `_acquire_run`."""
    held = one_run_on(station.station.id, home)
    with held, status_file(station, procedure, home, report) as reporting:
        left = left_run(station, procedure, home) if resume else None
        return _acquire_run(station, procedure, home, reporting, ask, is_paused, left)


def _acquire_run(
    station: StationFile,
    procedure: Procedure,
    home: Home,
    report: Callable[[Progress], None],
    ask: Ask | None,
    is_paused: Callable[[], bool],
    left: LeftRun | None,
) -> tuple[Run, Acquired]:
    """Acquire a run, with its recording in the home from the first sample on.

    ask: has a person turn the unit over, where the station cannot. is_paused: asked before each
    segment, which waits until it is so no more. left: an interrupted run that goes on as this one.

    If the run breaks off, what was recorded stays in the home's `acquiring` folder as an MCAP
    file, and the sentence of Unusable or BrokenOff says where. A file without a reading of the
    unit is removed.
    """
    began = datetime.now(UTC)
    new_id = f"{station.unit.serial}-{procedure.name}-{began:%Y%m%dT%H%M%SZ}"
    recording_id = left.recording.manifest.recording_id if left else new_id
    raw = home.acquiring / f"{began:%Y%m%dT%H%M%SZ}-{secrets.token_hex(4)}.mcap"
    with writing_in_home(raw):
        sink = RawWriter(raw)
    try:
        with sink:
            earlier = _take_over(left, station, sink) if left else None
            acquired = acquire(
                RunRequest(station, procedure, sink, report, recording_id, ask, is_paused, earlier)
            )
        run, _ = runs.add(read_mcap(raw), home)
    except Unusable as fault:
        _forget(left)
        raise Unusable(_with_what_is_left(fault, sink, raw)) from fault
    except OSError as fault:
        why = fault.strerror or fault
        raise BrokenOff(f"the recording could not be written ({why}){_left(sink, raw)}") from fault
    except KeyboardInterrupt as stop:
        _forget(left)
        raise BrokenOff(f"stopped by the operator{_left(sink, raw)}") from stop
    _forget(left)
    raw.unlink()
    return run, acquired


def _forget(left: LeftRun | None) -> None:
    if left is not None:
        left.forget()


def _take_over(left: LeftRun, station: StationFile, sink: RawWriter) -> Interrupted:
    """Begin the new file with what an interrupted run recorded."""
    earlier = interrupted(left.recording, station.unit_link)
    sink.manifest(earlier.manifest)
    for name, stream in left.recording.streams().items():
        sink.append(name, stream)
    return earlier


def _with_what_is_left(fault: Unusable, sink: RawWriter, raw: Path) -> str:
    """The fault and what is left; where nothing is, only why the run stopped."""
    left = _left(sink, raw)
    plain = fault.__cause__ if not left and isinstance(fault.__cause__, Unusable) else fault
    return f"{str(plain).rstrip('.')}{left}" if left else str(plain)


def _left(sink: RawWriter, raw: Path) -> str:
    """What a run that broke off leaves behind, as the end of a sentence."""
    if not sink.readings:
        raw.unlink(missing_ok=True)
        return ""
    return (
        f"; recorded so far: {raw} (`mimucal acquire --resume` goes on with it, "
        "`mimucal import --salvage` takes it in as it is)"
    )
