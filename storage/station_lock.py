"""One station, one run: a lock that ends with the process that holds it, however it ends."""

import fcntl
import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager

from schemas.base import Unusable
from storage.home import Home
from storage.whole_files import writing_in_home


@contextmanager
def one_run_on(station: str, home: Home) -> Iterator[None]:
    """The station with this id for the length of the block.

    Raises Unusable, naming the process, where a run of this home holds it.
    """
    file = home.locks / f"{hashlib.sha256(station.encode()).hexdigest()[:16]}.lock"
    with writing_in_home(file):
        lock = file.open("a+", encoding="utf-8")
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
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
