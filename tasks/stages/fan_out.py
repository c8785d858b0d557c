"""Runs the same work on many inputs, in this process or in several processes.

What is wide fans out inside a stage (deploy/decisions.md); Prefect sees the stage alone.
"""

import multiprocessing
import os
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")

QUEUED = 2  # items queued for each worker, so that none is idle and few are in memory
MAX_DEATHS = 2  # worker deaths on one item, after which it is abandoned
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def fan_out(
    work: Callable[[T], R], things: Sequence[T], workers: int, died: Callable[[T], R]
) -> Iterator[R]:
    """The result of the work on each thing, in order of completion; a single worker is this
    process.

    work and things have to be picklable. If a worker dies, only its current item is lost, and
    another worker repeats it; `died` gives the result of an item that killed two workers.
    """
    if min(workers, len(things)) <= 1:
        yield from map(work, things)
        return
    left, deaths = dict(enumerate(things)), Counter[int]()
    while left:
        alone = [k for k in left if deaths[k]]  # what may have killed a worker, run alone
        at_once = 1 if alone else workers
        try:
            for k, done in _in_pool(work, left, alone or list(left), at_once):
                del left[k]
                yield done
        except _Broken as broken:
            deaths.update(broken.at_work)
            for k in [k for k in broken.at_work if deaths[k] >= MAX_DEATHS]:
                yield died(left.pop(k))


class _Broken(Exception):  # noqa: N818 (how the pool tells what it was at)
    def __init__(self, at_work: list[int]) -> None:
        super().__init__(at_work)
        self.at_work = at_work


def _in_pool(
    work: Callable[[T], R], things: dict[int, T], keys: list[int], workers: int
) -> Iterator[tuple[int, R]]:
    """Works through some things in a pool of its own; raises _Broken when a worker died."""
    context = multiprocessing.get_context("spawn")
    waiting, running = iter(keys), dict[Future[R], int]()
    with _one_thread(), ProcessPoolExecutor(workers, context, _prepare) as pool:
        try:
            while True:
                for k in waiting:
                    running[pool.submit(work, things[k])] = k
                    if len(running) >= QUEUED * workers:
                        break
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    done = future.result()
                    yield running.pop(future), done
        except BrokenProcessPool as end:
            # The pool gives them to workers in the order of submission.
            raise _Broken(sorted(running.values())[:workers]) from end
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Children compute with one thread each: there are as many of them as processors."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value


def _prepare() -> None:
    """A worker leaves Ctrl-C to its parent, and ends with it however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
