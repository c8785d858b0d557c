"""Stage: acquires a run on a station, writing raw data as they arrive; another stores it."""

import os
import secrets
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from schemas.base import BrokenOff, Unusable
from schemas.procedure import Procedure
from schemas.recording import ENDED, Manifest, Recording, RunStatus, State
from schemas.station import StationFile
from schemas.text import Statement
from storage import settings
from storage.catalogue.runs import Run
from storage.formats.mcap.reader import NothingWhole, has_readings, read_mcap
from storage.formats.mcap.writer import RawWriter
from storage.home import Home
from storage.stations import lock_place, statuses, write_status
from storage.whole_files import writing_in_home
from tasks.stages.stage import stage
from tasks.stages.stoppable import stop_watch
from tasks.stages.store import ready_to_acquire, store, store_waiting
from tasks.station import procedures
from tasks.station.acquisition import Acquired, NewRecording, Progress, RunRequest, acquire
from tasks.station.connected_station import OPERATOR, StopRequested, StopSwitch, stopped_by
from tasks.station.ports import Ask
from tasks.station.run_manifest import interrupted
from tasks.words import Sayable, cause_of, message

# Interrupted runs of a station, its units and a procedure.

EMPTY_S = 600.0  # by then every run has homed its table, and written its first readings


@dataclass(frozen=True)
class InterruptedRun:
    """An interrupted run: what is whole of it, and its files: attempts to go on leave more."""

    recording: Recording
    paths: tuple[Path, ...]

    def forget(self) -> None:
        """Its content is now complete in another file."""
        for path in self.paths:
            path.unlink(missing_ok=True)


def left_runs(station: StationFile, procedure: Procedure, home: Home) -> dict[str, InterruptedRun]:
    """The last one of each unit on this station by this procedure, by the unit's serial.

    A unit without one is not in it. Raises Unusable where none has one.
    """
    known = dict(_known(home))
    found = {}
    for alone in station.per_unit():
        if left := _last_of(alone, procedure, known):
            found[alone.unit.serial] = left
    if not found:
        raise Unusable(
            f"{home.acquiring} has no interrupted run of unit {station.unit.serial} by procedure "
            f"{procedure.name} on station {station.station.id}: start a run without --resume"
        )
    return found


def _last_of(
    station: StationFile, procedure: Procedure, known: dict[Path, tuple[Manifest, Recording | None]]
) -> InterruptedRun | None:
    left = {
        path: (_began(manifest), recording)
        for path, (manifest, recording) in known.items()
        if _is_of(manifest, station, procedure)
    }
    read = [(began, recording) for began, recording in left.values() if recording is not None]
    if not read:
        return None
    last, longest = max(read, key=lambda each: (each[0], each[1].imu.t[-1]))
    return InterruptedRun(
        longest, tuple(path for path, (began, _) in left.items() if began == last)
    )


def _known(home: Home) -> Iterator[tuple[Path, tuple[Manifest, Recording | None]]]:
    """What each file says; no recording of one that was killed before its first readings."""
    for path in sorted(home.acquiring.glob("*.mcap")):
        try:
            recording = read_mcap(path, salvage=True)
        except NothingWhole as fault:
            yield path, (fault.manifest, None)
        except Unusable:
            continue
        else:
            yield path, (recording.manifest, recording)


def _is_of(manifest: Manifest, station: StationFile, procedure: Procedure) -> bool:
    fields = manifest.model_extra or {}
    return (
        (manifest.unit, manifest.station, manifest.mount)
        == (station.unit, station.station, station.mount)
        and fields.get("procedure") == procedure.name
        and "station_time_origin_s" in fields
    )


def _began(manifest: Manifest) -> str:
    return str((manifest.model_extra or {})["recorded_at"])


def forget_empty(home: Home) -> None:
    """Remove files of runs that were killed before their first readings."""
    written = {
        path for status, is_dead in statuses(home) if not is_dead for path in status.recordings
    }
    for path in home.acquiring.glob("*.mcap"):
        with suppress(OSError):
            left = path.stat()
            is_old = time.time() - left.st_mtime > EMPTY_S
            if is_old and str(path) not in written and not has_readings(path):
                path.unlink()


WRITE_EVERY_S = 1.0


@dataclass(frozen=True)
class RawRecording:
    """A raw file that is being written, and the interrupted run it continues."""

    new: NewRecording
    sink: RawWriter
    path: Path
    left: InterruptedRun | None

    def take_over(self) -> None:
        """Begin the file with what an interrupted run recorded."""
        if self.left is None or self.new.earlier is None:
            return
        self.sink.manifest(self.new.earlier.manifest)
        for name, stream in self.left.recording.streams().items():
            self.sink.append(name, stream)

    def forget(self) -> None:
        """The file holds all of what the interrupted run left."""
        if self.left is not None:
            self.left.forget()


@dataclass(frozen=True)
class Measured:
    """What a run on a station gave: the recordings of whole runs, in the home's `acquired` folder.

    given_up: a sentence for each unit that was given up on the way.
    """

    whole: tuple[tuple[Path, Acquired], ...]
    given_up: tuple[Unusable, ...] = ()


@dataclass(frozen=True)
class AcquiredRuns:
    """A run of each unit, and a sentence for each unit that was given up on the way."""

    kept: tuple[tuple[Run, Acquired], ...]
    given_up: tuple[Unusable, ...] = ()


def acquire_run(
    station: StationFile,
    procedure: Procedure,
    home: Home,
    report: Callable[[Progress], None],
    ask: Ask | None = None,
    is_paused: Callable[[], bool] = lambda: False,
    resume: bool = False,
    stop: StopSwitch | None = None,
    operator: str | None = None,
) -> AcquiredRuns:
    """Acquire a run while no other is going on at the station, and store it: two stages.

    stop: ends it, as a request of `stop_station` does. operator: who carries it out, which the
    recording says.

    Raises Unusable, before anything turns, for a station, home or catalogue that is not ready.
    What an earlier run could not store is stored first.
    """
    stop, raw = stop or StopSwitch(), list[RawRecording]()
    ready_to_acquire(station.station.id, home)
    forget_empty(home)
    store_waiting(home)
    held = stop_watch(station, home, stop)
    with held, status_file(station, procedure, home, report, raw) as reporting:

        def unless_stopped(progress: Progress) -> None:
            stop.check()
            reporting(progress)

        left = left_runs(station, procedure, home) if resume else None
        measured = measure(
            station, procedure, home, unless_stopped, ask, is_paused, left, stop, raw, operator
        )
        kept = tuple(
            (store(path, home, sleep=stop.sleep), acquired) for path, acquired in measured.whole
        )
    return AcquiredRuns(kept, measured.given_up)


@stage("acquire", again=False)
def measure(  # noqa: PLR0913 (what a run is, and who follows it)
    station: StationFile,
    procedure: Procedure,
    home: Home,
    report: Callable[[Progress], None],
    ask: Ask | None,
    is_paused: Callable[[], bool],
    left: Mapping[str, InterruptedRun] | None,
    stop: StopSwitch,
    raw: list[RawRecording],
    operator: str | None,
) -> Measured:
    """Run a procedure on a station, with its recordings in the home from the first sample on.

    ask: has a person remount the unit, where the station cannot. is_paused: checked before each
    segment, which waits while it is true. left: interrupted runs by the serial of the unit; they go
    on, and the other units are not measured. raw: is filled with the recordings.

    If the run breaks off, what was recorded stays in the home's `acquiring` folder as MCAP
    files, and the sentence of Unusable or BrokenOff says where. So does what was recorded of a
    unit that was given up.
    """
    try:
        with ExitStack() as sinks:
            for alone in station.per_unit():
                if left is None or alone.unit.serial in left:
                    its_left = (left or {}).get(alone.unit.serial)
                    raw.append(begun(alone, procedure, home, its_left, operator))
                    sinks.enter_context(raw[-1].sink)
                    raw[-1].take_over()
            new = tuple(each.new for each in raw)
            made = acquire(RunRequest(station, procedure, new, report, ask, is_paused, stop))
    except Unusable as fault:
        _forget(raw)
        raise Unusable(_with_what_is_left(fault, raw), cause_of(fault)) from fault
    except OSError as fault:
        sentence, cause = _broken(fault, raw)
        raise BrokenOff(f"{sentence}{what_is_left(raw)}", cause) from fault
    except (KeyboardInterrupt, StopRequested) as end:
        _forget(raw)
        by = stop.by or OPERATOR
        raise BrokenOff(f"stopped by {by}{what_is_left(raw)}", stopped_by(by)) from end
    _forget(raw)
    whole = tuple(
        (_moved(each.path, home), acquired)
        for each, acquired in zip(raw, made, strict=True)
        if acquired.given_up is None
    )
    return Measured(whole, tuple(_given_up(raw, made)))


def _moved(path: Path, home: Home) -> Path:
    """A recording among those that wait to be stored: `--resume` does not go on with it."""
    target = home.acquired / path.name
    with writing_in_home(target):
        return path.rename(target)


def _broken(fault: OSError, raw: list[RawRecording]) -> tuple[str, Sayable]:
    """Whether it was the recording that could not be written, or something else that failed."""
    why = fault.strerror or str(fault) or type(fault).__name__
    if any(each.sink.is_broken for each in raw):
        cause = message("station-cause.not-written", why=why)
        return f"the recording could not be written ({why})", cause
    return f"the run broke off ({why})", message("station-log-stopped", cause=why)


def _given_up(raw: list[RawRecording], made: tuple[Acquired, ...]) -> Iterator[Unusable]:
    for each, acquired in zip(raw, made, strict=True):
        if acquired.given_up is not None:
            why, serial = acquired.given_up.rstrip("."), each.new.station.unit.serial
            cause = message("station-cause.given-up", unit=serial, cause=acquired.cause or why)
            yield Unusable(f"unit {serial} was given up: {why}{what_is_left([each])}", cause)


def _forget(raw: list[RawRecording]) -> None:
    for each in raw:
        each.forget()


def _with_what_is_left(fault: Unusable, raw: list[RawRecording]) -> str:
    """The fault and what is kept; if nothing is, only why the run stopped."""
    left = what_is_left(raw)
    plain = fault.__cause__ if not left and isinstance(fault.__cause__, Unusable) else fault
    return f"{str(plain).rstrip('.')}{left}" if left else str(plain)


def begun(
    station: StationFile,
    procedure: Procedure,
    home: Home,
    left: InterruptedRun | None,
    operator: str | None,
) -> RawRecording:
    """A new file for the unit of a station; raises Unusable where the home takes none."""
    began = datetime.now(UTC)
    recording_id = f"{station.unit.serial}-{procedure.name}-{began:%Y%m%dT%H%M%SZ}"
    earlier = None
    if left is not None:
        recording_id = left.recording.manifest.recording_id
        earlier = interrupted(left.recording, station.unit_link)
    path = home.acquiring / f"{began:%Y%m%dT%H%M%SZ}-{secrets.token_hex(4)}.mcap"
    with writing_in_home(path):
        sink = RawWriter(path)
    new = NewRecording(station, sink, recording_id, earlier, operator)
    return RawRecording(new, sink, path, left)


def what_is_left(recordings: Iterable[RawRecording]) -> str:
    """What a run that broke off leaves behind, as the end of a sentence; else nothing.

    A file without a reading of the unit is removed.
    """
    paths = []
    for raw in recordings:
        if raw.sink.readings:
            paths.append(str(raw.path))
        else:
            raw.path.unlink(missing_ok=True)
    if not paths:
        return ""
    it = "it" if len(paths) == 1 else "them"
    return (
        f"; recorded so far: {', '.join(paths)} (`mimucal acquire --resume` goes on with {it}, "
        f"`mimucal import --salvage` takes {it} in as {'it is' if it == 'it' else 'they are'})"
    )


@contextmanager
def status_file(
    station: StationFile,
    procedure: Procedure,
    home: Home,
    report: Callable[[Progress], None],
    raw: Sequence[RawRecording] = (),
) -> Iterator[Callable[[Progress], None]]:
    """Gives the report that also writes the status: at every change, and every WRITE_EVERY_S.

    An exception is written as the cause for which the run stopped.
    """
    began, written_s = datetime.now(UTC), 0.0
    last = Progress("connecting", 0.0, 0.0, 0.0)
    units = tuple(alone.unit.serial for alone in station.per_unit())

    def write(state: State, cause: str = "", shown: Statement | None = None) -> None:
        nonlocal written_s
        written_s = time.monotonic()
        status = RunStatus(
            station=station.station.id, procedure=procedure.name, units=units, process=os.getpid(),
            began_at=began, at=datetime.now(UTC), state=state, now=last.now,
            segment=last.segment, segments=last.segments, station_s_done=last.station_s_done,
            station_s_total=last.station_s_total, wall_s_left=last.wall_s_left,
            rates_hz=last.rates_hz, noise=last.noise, alarms=last.alarms, cause=cause,
            shown_cause=shown,
            recordings=tuple(str(each.path) for each in raw if each.path.exists()),
            lock=lock_place(home),
        )  # fmt: skip
        write_status(status, home)

    def reporting(progress: Progress) -> None:
        nonlocal last
        is_new = (progress.state, progress.now) != (last.state, last.now)
        last = progress
        if is_new or time.monotonic() - written_s >= WRITE_EVERY_S:
            # The run is done once its recording is in the store.
            write("finishing" if progress.state in ENDED else progress.state)
        with suppress(OSError):  # a closed progress display does not end the run
            report(progress)

    write("begun")
    try:
        yield reporting
    except BaseException as fault:
        write("stopped", str(fault) or type(fault).__name__, cause_of(fault))
        raise
    write("done")


# The procedure that an order names.


FILES = (".toml", ".json")


def procedure_named(name: str) -> Procedure:
    """The procedure of a file, or that of a name; raises Unusable where there is neither."""
    if Path(name).suffix in FILES:
        return settings.read(Path(name), Procedure)
    return procedures.load(name)
