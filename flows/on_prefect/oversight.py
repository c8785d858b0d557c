"""A flow run that stops by itself where its worker can no longer stop it.

A worker stops its flow run when Prefect cancels it; one that died, or that stopped polling because
the server was down, does not. The process of the run therefore polls as well.
"""

import os
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tasks.stages.prefect_api import NotAnswered, get
from tasks.station.stopping import CANCELLATION, LOSS

LOOK_S = 1.0
ASK_EVERY = 3  # looks
FLOW_RUN = "PREFECT__FLOW_RUN_ID"  # set by a worker for the process that it starts
CANCELLED = ("CANCELLING", "CANCELLED")


@contextmanager
def overseen(stop: Callable[[str], object]) -> Iterator[None]:
    """Calls `stop`, once and with the cause, if the worker is gone or Prefect cancels the run.

    It is called in another thread, and only within the block. Outside of a worker's process
    nothing is looked for.
    """
    run = os.environ.get(FLOW_RUN)
    if run is None:
        yield
        return
    ended, ending = threading.Event(), threading.Lock()
    worker = os.getppid()

    def look_until_the_end() -> None:
        looks = 0
        while not ended.wait(LOOK_S):
            looks += 1
            is_lost = os.getppid() != worker
            if is_lost or (looks % ASK_EVERY == 0 and is_cancelled(run)):
                with ending:
                    if not ended.is_set():
                        stop(LOSS if is_lost else CANCELLATION)
                return

    threading.Thread(target=look_until_the_end, daemon=True).start()
    try:
        yield
    finally:
        with ending:
            ended.set()


def is_cancelled(run: str) -> bool:
    """Whether Prefect has a flow run as cancelled; False of a server that does not answer."""
    try:
        return get(f"/flow_runs/{run}").get("state_type") in CANCELLED
    except NotAnswered:
        return False
