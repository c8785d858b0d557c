"""One order at a time at each station, and one process that takes them: locks like those of its
runs. The holder of the lock of a station's orders knows that any other order in progress was left
by a process that died.
"""

import fcntl
from collections.abc import Iterator
from contextlib import contextmanager

from storage.home import Home
from storage.station_lock import lock_of
from storage.whole_files import writing_in_home


@contextmanager
def one_order_at(station: str, home: Home) -> Iterator[None]:
    """The orders of a station for the length of the block, once nobody else has them."""
    with _open(f"orders of {station}", home) as lock:
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
    with _open(name, home) as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
        else:
            yield True


@contextmanager
def _open(name: str, home: Home) -> Iterator[int]:
    file = lock_of(name, home)
    with writing_in_home(file):
        lock = file.open("a")
    with lock:
        yield lock.fileno()
