"""Stage: acquires a run on a station, writing raw data as they arrive, and stores it."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass

from schemas.base import BrokenOff, Unusable
from schemas.procedure import Procedure
from schemas.station import StationFile
from storage.catalogue import runs
from storage.catalogue.run_index import Run
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from storage.station_lock import one_run_on
from tasks.stages.left_run import LeftRun, left_runs
from tasks.stages.raw_recordings import RawRecording, begun, what_is_left
from tasks.stages.run_status import status_file
from tasks.stages.stage import stage
from tasks.station.acquisition import Acquired, RunRequest, acquire
from tasks.station.ports import Ask
from tasks.station.progress import Progress


@dataclass(frozen=True)
class AcquiredRuns:
    """A run of each unit, and a sentence for each unit that was given up on the way."""

    kept: tuple[tuple[Run, Acquired], ...]
    given_up: tuple[str, ...] = ()


@stage("acquire", again=False)
def acquire_run(
    station: StationFile,
    procedure: Procedure,
    home: Home,
    report: Callable[[Progress], None],
    ask: Ask | None = None,
    is_paused: Callable[[], bool] = lambda: False,
    resume: bool = False,
) -> AcquiredRuns:
    """Acquire a run while no other is going on at the station; see `_acquire_run`."""
    held = one_run_on(station.station.id, home)
    with held, status_file(station, procedure, home, report) as reporting:
        left = left_runs(station, procedure, home) if resume else None
        return _acquire_run(station, procedure, home, reporting, ask, is_paused, left)


def _acquire_run(
    station: StationFile,
    procedure: Procedure,
    home: Home,
    report: Callable[[Progress], None],
    ask: Ask | None,
    is_paused: Callable[[], bool],
    left: Mapping[str, LeftRun] | None,
) -> AcquiredRuns:
    """Acquire a run, with its recordings in the home from the first sample on.

    ask: has a person turn the unit over, where the station cannot. is_paused: asked before each
    segment, which waits until it is so no more. left: interrupted runs by the serial of the unit;
    they go on, and the other units are not measured.

    If the run breaks off, what was recorded stays in the home's `acquiring` folder as MCAP
    files, and the sentence of Unusable or BrokenOff says where. So does what was recorded of a
    unit that was given up.
    """
    raw: list[RawRecording] = []
    try:
        with ExitStack() as sinks:
            for alone in station.per_unit():
                if left is None or alone.unit.serial in left:
                    raw.append(begun(alone, procedure, home, (left or {}).get(alone.unit.serial)))
                    sinks.enter_context(raw[-1].sink)
                    raw[-1].take_over()
            new = tuple(each.new for each in raw)
            made = acquire(RunRequest(station, procedure, new, report, ask, is_paused))
        kept = tuple(
            (runs.add(read_mcap(each.path), home)[0], acquired)
            for each, acquired in zip(raw, made, strict=True)
            if acquired.given_up is None
        )
    except Unusable as fault:
        _forget(raw)
        raise Unusable(_with_what_is_left(fault, raw)) from fault
    except OSError as fault:
        why = fault.strerror or fault
        raise BrokenOff(f"the recording could not be written ({why}){what_is_left(raw)}") from fault
    except KeyboardInterrupt as stop:
        _forget(raw)
        raise BrokenOff(f"stopped by the operator{what_is_left(raw)}") from stop
    _forget(raw)
    for each, acquired in zip(raw, made, strict=True):
        if acquired.given_up is None:
            each.path.unlink()
    return AcquiredRuns(kept, tuple(_given_up(raw, made)))


def _given_up(raw: list[RawRecording], made: tuple[Acquired, ...]) -> Iterator[str]:
    for each, acquired in zip(raw, made, strict=True):
        if acquired.given_up is not None:
            why, serial = acquired.given_up.rstrip("."), each.new.station.unit.serial
            yield f"unit {serial} was given up: {why}{what_is_left([each])}"


def _forget(raw: list[RawRecording]) -> None:
    for each in raw:
        each.forget()


def _with_what_is_left(fault: Unusable, raw: list[RawRecording]) -> str:
    """The fault and what is kept; if nothing is, only why the run stopped."""
    left = what_is_left(raw)
    plain = fault.__cause__ if not left and isinstance(fault.__cause__, Unusable) else fault
    return f"{str(plain).rstrip('.')}{left}" if left else str(plain)
