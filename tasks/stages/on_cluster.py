"""Runs the same work on many inputs, by the workers of a dask cluster."""

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import suppress
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, TypeVar

from schemas.base import Unusable
from tasks.version import code_version

if TYPE_CHECKING:
    from distributed import Client, Future

T = TypeVar("T")
R = TypeVar("R")

QUEUED = 3  # batches on their way to each thread of a worker
BATCH_S = 2.0  # of work in a batch: dask takes some 15 ms for each, client and scheduler together
PATIENCE_S = 120.0  # long enough for a scheduler to restart
ANSWER_S = 10.0  # for a scheduler to answer
# Builtins only, which any worker can unpickle: one that cannot fails silently, and the client would
# wait forever.
VERSION_QUERY = (eval, "__import__('tasks.version', fromlist='_').code_version()")


def on_cluster(
    work: Callable[[T], R], things: Sequence[T], scheduler: str, died: Callable[[T], R]
) -> Iterator[R]:
    """The work on each thing, in the order in which it is done.

    The current item of a lost worker goes to another; `died` gives the result of an item that dask
    abandons because workers die on it. After a restart of the scheduler whatever was not done is
    begun again. Raises Unusable when no scheduler answers for two minutes.
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
    with _connected(scheduler) as client:
        _check_workers(client, scheduler)
        suspects, batches = list[int](), _Batches(left)
        for batch, made in _made(client, work, left, batches, partial(_at_a_time, client)):
            if made is None:
                suspects.extend(batch)
                continue
            seconds, done = made
            batches.put_back(batch[len(done) :])
            yield from zip(batch[: len(done)], done, strict=True)
            batches.measure(seconds / len(done), _at_a_time(client))
        # An item that kills workers takes their other items with it: each is retried once, alone.
        for (k,), made in _made(client, work, left, iter([[k] for k in suspects]), lambda: 1):
            yield k, died(left[k]) if made is None else made[1][0]


def _made(
    client: "Client",
    work: Callable[[T], R],
    things: dict[int, T],
    batches: Iterator[list[int]],
    most: Callable[[], int],
) -> Iterator[tuple[list[int], tuple[float, list[R]] | None]]:
    """Each batch with its seconds and results, None where workers die at it; most: at a time."""
    from distributed import Future
    from distributed.scheduler import KilledWorker

    running = dict[Future, list[int]]()
    while True:
        for batch in islice(batches, max(0, most() - len(running))):
            sent = client.submit(_each, work, [things[k] for k in batch], pure=False)
            running[sent] = batch
        if not running:
            return
        _wait(client, list(running))
        for future in [each for each in running if each.status != "pending"]:
            made: tuple[float, list[R]] | None = None
            with suppress(KilledWorker):
                made = future.result()
            future.release()
            yield running.pop(future), made


def _wait(client: "Client", futures: "list[Future]") -> None:
    """Until one of them is done, or for ANSWER_S; raises ConnectionError without the scheduler."""
    from distributed import wait

    with suppress(TimeoutError):
        wait(futures, timeout=min(ANSWER_S, PATIENCE_S), return_when="FIRST_COMPLETED")
    if client.status != "running":
        raise ConnectionError("the connection to the scheduler was lost")


class _Batches(Iterator[list[int]]):
    """The numbers of what waits, one by one until a first one is done, then in batches of as many
    as take BATCH_S.
    """

    def __init__(self, waiting: Iterable[int]) -> None:
        self._waiting, self._size = deque(waiting), 1

    def __next__(self) -> list[int]:
        if not self._waiting:
            raise StopIteration
        return [self._waiting.popleft() for _ in range(min(self._size, len(self._waiting)))]

    def put_back(self, batch: Sequence[int]) -> None:
        """Returns what a worker did not get to; it goes out first."""
        self._waiting.extendleft(reversed(batch))

    def measure(self, seconds: float, most: int) -> None:
        """Takes note of the seconds of each; most: batches at a time, which are to end together."""
        self._size = max(1, min(len(self._waiting) // most, int(BATCH_S / max(seconds, 1e-3))))


def _each(work: Callable[[T], R], batch: Sequence[T]) -> tuple[float, list[R]]:
    """Seconds that it took, and the results in order; it stops after BATCH_S, so that there may be
    fewer results than things.
    """
    began, done = time.monotonic(), list[R]()
    for thing in batch:
        done.append(work(thing))
        if time.monotonic() - began > BATCH_S:
            break
    return time.monotonic() - began, done


def _connected(scheduler: str) -> "Client":
    from distributed import Client

    try:
        return Client(scheduler, timeout=ANSWER_S)
    except ValueError as fault:
        raise Unusable(f"--scheduler {scheduler}: {fault}; give tcp://HOST:PORT") from fault
    except AssertionError as busy:  # dask's own thread has ten seconds to start on a busy computer
        raise TimeoutError("dask's thread did not start in time") from busy


def _check_workers(client: "Client", scheduler: str) -> None:
    """Raises Unusable where no worker comes, or one is without this version of mimucal."""
    asked, gives_up = client.submit(*VERSION_QUERY, pure=False), time.monotonic() + PATIENCE_S
    while asked.status == "pending":  # a cluster may start its workers for the first work
        _wait(client, [asked])
        if asked.status == "pending" and time.monotonic() > gives_up:
            raise Unusable(
                f"--scheduler {scheduler}: it has no worker; start some with `dask worker "
                f"{scheduler}`, and give the same command again"
            )
    mine = code_version()
    for worker, version in client.run(*VERSION_QUERY, on_error="return").items():
        if version != mine and not isinstance(version, OSError):  # that was lost just now
            raise Unusable(
                f"--scheduler {scheduler}: its worker {worker} has {version}, not {mine}; install "
                "this version of mimucal there, restart it, and give the same command again"
            )


def _at_a_time(client: "Client") -> int:
    """How many batches, of the workers that there are now."""
    return QUEUED * max(1, sum(client.nthreads().values()))
