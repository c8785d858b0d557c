"""The stations of a home: their station files, in its `stations` folder."""

import fcntl
import hashlib
import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TextIO, TypeVar

from pydantic import BaseModel, ValidationError

from schemas.base import NotThere, Unusable
from schemas.recording import ENDED, RunStatus
from schemas.station import StationFile, StopAnswer, StopRequest
from schemas.text import Message, Statement
from storage import settings
from storage.home import Home
from storage.whole_files import drafted, make_folder, writing_in_home


def folder_of(home: Home) -> Path:
    """Where a home keeps the files of its stations."""
    return home.path / "stations"


def station_files(home: Home) -> tuple[str, ...]:
    """The names of those files."""
    found = (path.name for path in folder_of(home).glob("*") if path.suffix in (".toml", ".json"))
    return tuple(sorted(name for name in found if not name.startswith(".")))


def station_ids(home: Home) -> tuple[str, ...]:
    """The ids of the home's stations, as far as their files can be read."""
    found = set()
    for name in station_files(home):
        with suppress(Unusable):
            found.add(settings.read(folder_of(home) / name, StationFile).station.id)
    return tuple(sorted(found))


def file_of(station: str, home: Home) -> Path:
    """The station file of the station with this id.

    Raises NotThere for one that is not among the home's, Unusable for one that is there twice.
    """
    files = [folder_of(home) / name for name in station_files(home)]
    found = [path for path in files if settings.read(path, StationFile).station.id == station]
    if not found:
        raise NotThere(
            f"{folder_of(home)} has no file of station {station}; add it with "
            "`mimucal station add FILE`"
        )
    if len(found) > 1:
        raise Unusable(
            f"{' and '.join(map(str, found))} are both of station {station}; keep the one that "
            "counts"
        )
    return found[0]


def file_named(station: str, home: Home) -> Path:
    """A station file by its path, or by the id of its station; raises Unusable as `file_of`."""
    path = Path(station)
    return path if path.suffix.lower() in settings.READERS else file_of(station, home)


def keep(file: Path, home: Home) -> Path:
    """Takes a station file among the home's, in the place of the one with its id; where it lies.

    Only the owner reads it: a link to a device may have a password.
    """
    id_ = settings.read(file, StationFile).station.id
    before = [folder_of(home) / name for name in station_files(home)]
    own = [path for path in before if settings.read(path, StationFile).station.id == id_]
    target = folder_of(home) / f"{id_}{file.suffix}"
    content = file.read_bytes()
    with writing_in_home(target), drafted(target) as draft:
        draft.write_bytes(content)
        draft.chmod(0o600)
    for path in own:
        if path != target:
            path.unlink()
    return target


# One run at a time on each station, and its status: a lock that ends with its process.

SILENCE = timedelta(seconds=30)  # after which a process on another computer counts as dead
LOOK_S = 0.2  # longest time for which `is_held` blocks a run's lock


def hashed(station: str) -> str:
    """What stands for a station in the names of its files."""
    return hashlib.sha256(station.encode()).hexdigest()[:16]


def lock_of(station: str, home: Home) -> Path:
    """The file by which runs of a station exclude each other."""
    return home.locks / f"{hashed(station)}.lock"


def is_held(station: str, home: Home) -> bool:
    """Whether a run holds the station: one whose process ended does not."""
    try:
        with lock_of(station, home).open() as lock:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except FileNotFoundError:
        return False
    return False


# One order at a time at each station, and one process that takes them. The holder of the lock of a
# station's orders knows that any other order in progress was left by a process that died.


@contextmanager
def one_order_at(station: str, home: Home) -> Iterator[None]:
    """The orders of a station for the length of the block, once nobody else has them."""
    with _opened(f"orders of {station}", home) as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@contextmanager
def no_order_at(station: str, home: Home) -> Iterator[bool]:
    """Whether nobody has the orders of a station; then this process has, for the block."""
    with _if_free(f"orders of {station}", home) as is_free:
        yield is_free


@contextmanager
def only_worker_of(station: str, home: Home) -> Iterator[bool]:
    """Whether this process alone takes the orders of a station, for the length of the block."""
    with _if_free(f"worker of {station}", home) as is_alone:
        yield is_alone


@contextmanager
def _if_free(name: str, home: Home) -> Iterator[bool]:
    with _opened(name, home) as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
        else:
            yield True


@contextmanager
def _opened(name: str, home: Home) -> Iterator[int]:
    file = lock_of(name, home)
    with writing_in_home(file):
        lock = file.open("a")
    with lock:
        yield lock.fileno()


# Runs: one at a time at each station.


def is_running(process: int | None) -> bool:
    """Whether a process of this computer runs; one that ended and waits for its parent does not."""
    if process is None:
        return False
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # somebody else's
        return True
    try:
        stat = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:  # another system
        return True
    return stat.rpartition(")")[2].split()[:1] != ["Z"]


@contextmanager
def one_run_on(station: str, home: Home) -> Iterator[None]:
    """The station with this id for the length of the block.

    Raises Unusable, naming the process, where another run holds it: one of this home, or of any
    home with the same `station_side`.
    """
    file = lock_of(station, home)
    with writing_in_home(file):
        lock = file.open("a+", encoding="utf-8")
    with lock:
        try:
            _take(lock)
        except BlockingIOError:
            lock.seek(0)
            raise Unusable(
                f"a run is going on at station {station} (process {lock.read().strip()}): wait for "
                f"its end, or end it with `mimucal station stop`",
                Message("station-cause.busy", (("station", station),)),
            ) from None
        lock.truncate(0)
        lock.write(str(os.getpid()))
        lock.flush()
        yield


def _take(lock: TextIO) -> None:
    """Raises BlockingIOError where it is held for longer than somebody looks."""
    end_s = time.monotonic() + LOOK_S
    while True:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() > end_s:
                raise
            time.sleep(LOOK_S / 10)
        else:
            return


def lock_place(home: Home) -> str:
    """Where the runs of this computer hold their stations, for whoever reads their status."""
    return f"{socket.gethostname()}:{home.station_side}"


def write_status(status: RunStatus, home: Home) -> None:
    """Write how a run stands, beside its lock. A disk that refuses costs the status, and not the
    run.
    """
    with suppress(OSError):
        make_folder(home.station_status)
        _write_status(status, home.station_status)


def share_status(station: str, home: Home) -> None:
    """Write how a run of this computer stands, and that it lives, for other computers.

    Nothing where the home is on this computer; OSError where it cannot be written.
    """
    status = read_status(status_file_of(station, home.station_status))
    if status is None or home.station_side == home.path or not home.path.is_dir():
        return
    make_folder(home.status)
    lives = {} if status.state in ENDED else {"at": datetime.now(UTC)}
    _write_status(status.model_copy(update=lives), home.status)


def _write_status(status: RunStatus, folder: Path) -> None:
    with drafted(status_file_of(status.station, folder)) as draft:
        draft.write_text(status.model_dump_json(), encoding="utf-8")


def status_file_of(station: str, folder: Path) -> Path:
    """Where the status of a station stands in a folder."""
    return folder / f"{hashed(station)}.json"


def read_status(file: Path) -> RunStatus | None:
    """The status in a file; None where there is none that can be read."""
    with suppress(OSError, ValidationError):
        return RunStatus.model_validate_json(file.read_bytes())
    return None


def is_dead(status: RunStatus, home: Home) -> bool:
    """Whether a run's process died. On its own computer its lock shows this; on another, the age of
    its status.
    """
    if status.state in ENDED:
        return False
    if status.lock in ("", lock_place(home)):
        return not is_held(status.station, home)
    return datetime.now(UTC) - status.at > SILENCE


def end_status(station: str, cause: str, home: Home, shown: Statement | None = None) -> None:
    """If the status of a station's last run is not final, mark it as stopped.

    shown: the cause, as pages show it.
    """
    for folder in {home.station_status, home.status}:
        status = read_status(status_file_of(station, folder))
        if status is not None and status.state not in ENDED:
            ended = {
                "state": "stopped", "cause": cause, "shown_cause": shown, "at": datetime.now(UTC),
            }  # fmt: skip
            with suppress(OSError):
                _write_status(status.model_copy(update=ended), folder)


def end_dead_statuses(home: Home) -> None:
    """Mark every run whose process died as stopped."""
    for status, dead in statuses(home):
        if dead and not is_held(status.station, home):
            end_status(status.station, f"its process {status.process} ended without a word", home)


def statuses(home: Home) -> list[tuple[RunStatus, bool]]:
    """The last run of each station, and whether its process is dead: it ended without a word."""
    found: dict[str, RunStatus] = {}
    for folder in (home.status, home.station_status):
        for file in sorted(folder.glob("*.json")):
            status = read_status(file)
            if status is None:
                continue
            other = found.get(status.station)
            # of this computer's own run the status beside the lock counts
            if other is None or other.lock == status.lock or other.at <= status.at:
                found[status.station] = status
    return [(status, is_dead(status, home)) for _, status in sorted(found.items())]


# Requests to stop a station, what its run answers, and lockouts: files beside its lock.
#
# They need nothing but the folder: no database, no server. A request that another computer makes
# lies in the home, where the run looks as well.

M = TypeVar("M", bound=BaseModel)


def request_in(folder: Path, station: str) -> StopRequest | None:
    """The request in a folder of locks; None where there is none."""
    return _read(folder / f"{hashed(station)}.stop", StopRequest)


def request_stop(request: StopRequest, home: Home) -> bool:
    """Leave a request where the station's run looks; whether it could be written."""
    return _write_request(request, home.locks / f"{hashed(request.station)}.stop")


def take_back(folder: Path, station: str) -> None:
    """Remove a request that has had its answer, or was of an earlier run."""
    with suppress(OSError):
        (folder / f"{hashed(station)}.stop").unlink(missing_ok=True)


def answer_in(folder: Path, request: StopRequest) -> StopAnswer | None:
    """The answer to this request; None where there is none yet."""
    answer = _read(folder / f"{hashed(request.station)}.stopped", StopAnswer)
    return answer if answer is not None and answer.key == request.key else None


def answer_stop(answer: StopAnswer, folder: Path, station: str) -> None:
    """Answer a request in the folder in which it lies."""
    _write_request(answer, folder / f"{hashed(station)}.stopped")


def note_in_trail(request: StopRequest, home: Home) -> None:
    """Enter a stop in the audit trail, once; who released it sees to it where that failed."""
    from storage.catalogue import (  # late: a stop does not wait for their import
        audit_trail,
        database,
    )

    if database.for_reading(home) is None:
        return
    with database.changing(home) as connection:
        audit_trail.add_once(
            connection, request.by, "stop station", request.station, at=request.at, key=request.key
        )


def lock_out(request: StopRequest, home: Home) -> None:
    """Keep the orders of a station waiting after a stop, until somebody releases it."""
    _write_request(request, home.locks / f"{hashed(request.station)}.lockout")


def lockout_of(station: str, home: Home) -> StopRequest | None:
    """The stop after which nobody has released the station yet; None where it is released."""
    folders = (home.locks, home.shared_locks)
    found = (_read(folder / f"{hashed(station)}.lockout", StopRequest) for folder in folders)
    return next((each for each in found if each is not None), None)


def release(station: str, by: str, home: Home) -> None:
    """Let the orders of a station begin again, and enter in the audit trail who saw that it may
    turn, and the stop before; raises Unusable where that cannot be written.
    """
    from storage.catalogue import audit_trail, database  # late, as above

    stop = lockout_of(station, home)
    if stop is not None:
        note_in_trail(stop, home)
        with database.changing(home) as connection:
            audit_trail.add(connection, by, "release station", station, key=stop.key)
    for folder in (home.locks, home.shared_locks):
        file = folder / f"{hashed(station)}.lockout"
        try:
            file.unlink(missing_ok=True)
        except OSError as error:
            raise Unusable(
                f"{file} cannot be removed ({error.strerror}), and station {station} stays locked "
                "out: give rights there, or remove it"
            ) from error


def keep_station_file(station: StationFile, home: Home) -> None:
    """Keep the file by which a station is run, so that it can be stopped without the home."""
    _write_request(station, home.locks / f"{hashed(station.station.id)}.station.json")


def kept_station_file(station: str, home: Home) -> StationFile | None:
    """The file by which a station was run last; None where it was never run here."""
    return _read(home.locks / f"{hashed(station)}.station.json", StationFile)


def _read(file: Path, model: type[M]) -> M | None:
    with suppress(OSError, ValidationError):
        return model.model_validate_json(file.read_bytes())
    return None


def _write_request(content: BaseModel, file: Path) -> bool:
    """The folder itself is made where only it is missing, and not where a disk is away."""
    with suppress(OSError):
        if file.parent.parent.is_dir():
            file.parent.mkdir(exist_ok=True)
        with drafted(file) as draft:
            draft.write_text(content.model_dump_json(), encoding="utf-8")
        return True
    return False
