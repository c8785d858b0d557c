"""One run at a time on each station, and its status: a lock that ends with its process."""

import fcntl
import hashlib
import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import TextIO

from pydantic import ValidationError

from schemas.base import Unusable
from schemas.run_log import ENDED, RunStatus
from schemas.text import Message, Statement
from storage.home import Home
from storage.whole_files import drafted, make_folder, writing_in_home

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
        _write(status, home.station_status)


def share_status(station: str, home: Home) -> None:
    """Write how a run of this computer stands, and that it lives, for other computers.

    Nothing where the home is on this computer; OSError where it cannot be written.
    """
    status = read_status(status_file_of(station, home.station_status))
    if status is None or home.station_side == home.path or not home.path.is_dir():
        return
    make_folder(home.status)
    lives = {} if status.state in ENDED else {"at": datetime.now(UTC)}
    _write(status.model_copy(update=lives), home.status)


def _write(status: RunStatus, folder: Path) -> None:
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
                _write(status.model_copy(update=ended), folder)


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
