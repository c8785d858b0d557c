"""A flow run that stops by itself where its worker can no longer stop it.

A worker stops its flow run when Prefect cancels it; one that is gone, or that gave up watching
because the server was away, does not. The process of the run therefore looks for itself.
"""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from tasks.stages.prefect_api import NotAnswered, get

LOOK_S = 1.0
ASK_EVERY = 3  # looks
FLOW_RUN = "PREFECT__FLOW_RUN_ID"  # set by a worker for the process that it starts
OPERATOR, WORKER = "the operator", "the loss of its Prefect worker"
CANCELLED = ("CANCELLING", "CANCELLED")


@contextmanager
def overseen() -> Iterator[Callable[[], str]]:
    """Ends the block by SIGTERM if the worker is gone, or Prefect has the run as cancelled.

    Yields the function that gives who or what stopped it. Outside of a worker's process nothing
    is looked for.
    """
    run = os.environ.get(FLOW_RUN)
    if run is None or threading.current_thread() is not threading.main_thread():
        yield lambda: OPERATOR
        return
    ended, ending, stopped_by = threading.Event(), threading.Lock(), [OPERATOR]
    main = threading.main_thread().ident or 0

    def look_until_the_end() -> None:
        worker, looks = os.getppid(), 0
        while not ended.wait(LOOK_S):
            looks += 1
            is_lost = os.getppid() != worker
            if is_lost or (looks % ASK_EVERY == 0 and is_cancelled(run)):
                with ending:
                    if not ended.is_set():
                        stopped_by[0] = WORKER if is_lost else OPERATOR
                        signal.pthread_kill(main, signal.SIGTERM)
                return

    looking = threading.Thread(target=look_until_the_end, daemon=True)
    looking.start()
    try:
        yield lambda: stopped_by[0]
    finally:
        with ending:
            ended.set()


def is_cancelled(run: str) -> bool:
    """Whether Prefect has a flow run as cancelled; a server that does not answer does not."""
    try:
        return get(f"/flow_runs/{run}").get("state_type") in CANCELLED
    except NotAnswered:
        return False
