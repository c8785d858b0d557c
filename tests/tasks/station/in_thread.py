"""A virtual station behind sockets, served by a thread of this process.

A process of its own, which tests/tasks/station/virtual/test_servers.py judges, takes seconds of
computing to start.
"""

import asyncio
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager

from schemas.station import StationFile
from tasks.station.virtual.config import VirtualStation
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.servers import serve


@contextmanager
def serving(
    config: VirtualStation, speed: float, faults: Iterable[StationFault] = ()
) -> Iterator[StationFile]:
    """In the place of `tasks.station.virtual.servers.running`."""
    started = Future[tuple[StationFile, Callable[[], object]]]()

    def ready(station: StationFile) -> None:
        loop, task = asyncio.get_running_loop(), asyncio.current_task()
        assert task is not None
        started.set_result((station, lambda: loop.call_soon_threadsafe(task.cancel)))

    def work() -> None:
        try:
            asyncio.run(serve(config, speed=speed, faults=faults, ready=ready))
        except asyncio.CancelledError:
            pass
        except Exception as error:
            started.set_exception(error)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    station, end = started.result()
    try:
        yield station
    finally:
        end()
        thread.join()
