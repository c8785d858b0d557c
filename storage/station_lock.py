"""One run at a time on each station: a lock that ends with the process that holds it."""

import fcntl
import hashlib
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TextIO

from pydantic import ValidationError

from schemas.base import Unusable
from schemas.run_log import ENDED, RunStatus
from storage.home import Home
from storage.whole_files import drafted, make_folder, writing_in_home

LOOK_S = 0.2  # for no longer does `is_held` keep a run from its lock


def lock_of(station: str, home: Home) -> Path:
    """The file by which runs of a station exclude each other; its stem stands for the station."""
    return home.locks / f"{hashlib.sha256(station.encode()).hexdigest()[:16]}.lock"


def is_held(station: str, home: Home) -> bool:
    """Whether a run of this home holds the station: one whose process ended does not."""
    try:
        with lock_of(station, home).open() as lock:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except FileNotFoundError:
        return False
    return False


@contextmanager
def one_run_on(station: str, home: Home) -> Iterator[None]:
    """The station with this id for the length of the block.

    Raises Unusable, naming the process, where a run of this home holds it.
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
                f"its end, or end it with Ctrl-C"
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


def write_status(status: RunStatus, home: Home) -> None:
    """Write how a run stands. A disk that refuses costs the status, and not the run."""
    file = home.status / f"{lock_of(status.station, home).stem}.json"
    with suppress(OSError):
        make_folder(file.parent)
        with drafted(file) as draft:
            draft.write_text(status.model_dump_json(), encoding="utf-8")


def statuses(home: Home) -> list[tuple[RunStatus, bool]]:
    """The last run of each station, and whether its process is dead: it ended without a word."""
    found = []
    for file in sorted(home.status.glob("*.json")):
        with suppress(OSError, ValidationError):
            status = RunStatus.model_validate_json(file.read_bytes())
            is_dead = status.state not in ENDED and not is_held(status.station, home)
            found.append((status, is_dead))
    return found
