"""Runs the same work on many inputs, by the workers of a dask cluster."""

import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import suppress
from itertools import islice
from typing import TYPE_CHECKING, TypeVar

from schemas.base import Unusable

if TYPE_CHECKING:
    from distributed import Client

T = TypeVar("T")
R = TypeVar("R")

WAITING = 3  # things on their way to each thread of a worker
PATIENCE_S = 120.0  # a scheduler that is restarted is there again by then
ANSWER_S = 10.0  # for a scheduler to answer


def on_cluster(
    work: Callable[[T], R], things: Sequence[T], scheduler: str, died: Callable[[T], R]
) -> Iterator[R]:
    """The work on each thing, in the order in which it is done.

    What a lost worker was at goes to another; what dask gives up, because workers die at it, is
    given by `died`. After a restart of the scheduler whatever was not done is begun again.
    Raises Unusable when no scheduler answers for two minutes.
    """
    left, patience = dict(enumerate(things)), time.monotonic()
    while left:
        try:
            for k, done in _while_connected(work, left, scheduler, died):
                del left[k]
                patience = time.monotonic()
                yield done
        except (OSError, CancelledError) as fault:  # of the connection; a timeout, too
            if time.monotonic() - patience > PATIENCE_S:
                raise Unusable(
                    f"--scheduler {scheduler}: no dask scheduler answers there; start it, and give "
                    "the same command again, which goes on where it was"
                ) from fault
            time.sleep(1.0)


def _while_connected(
    work: Callable[[T], R], left: dict[int, T], scheduler: str, died: Callable[[T], R]
) -> Iterator[tuple[int, R]]:
    """Ends when all is done; raises OSError or CancelledError when the scheduler is lost."""
    from distributed import Future, wait
    from distributed.scheduler import KilledWorker

    with _connected(scheduler) as client:
        waiting, running = iter(list(left)), dict[Future, int]()
        while True:
            most = WAITING * _threads(client)
            for k in islice(waiting, max(0, most - len(running))):
                running[client.submit(work, left[k], pure=False)] = k
            if not running:
                return
            with suppress(TimeoutError):
                wait(list(running), timeout=ANSWER_S, return_when="FIRST_COMPLETED")
            if client.status != "running":
                raise ConnectionError("the connection to the scheduler was lost")
            for future in [each for each in running if each.status != "pending"]:
                k = running.pop(future)
                try:
                    done = future.result()
                except KilledWorker:
                    done = died(left[k])
                future.release()
                yield k, done


def _connected(scheduler: str) -> "Client":
    from distributed import Client

    try:
        return Client(scheduler, timeout=ANSWER_S)
    except ValueError as fault:
        raise Unusable(f"--scheduler {scheduler}: {fault}; give tcp://HOST:PORT") from fault
    except AssertionError as busy:  # dask's own thread has ten seconds to start on a busy computer
        raise TimeoutError("dask's thread did not start in time") from busy


def _threads(client: "Client") -> int:
    return max(1, sum(client.nthreads().values()))
