"""The Prefect worker of a station: frees what the worker before it left, and takes orders."""

import os
import sys
from typing import NoReturn

from flows.on_prefect.prefect_queue import give_up_pending, pool_of
from flows.orders import order_queue
from storage.home import Home
from storage.stations import file_of


def work(station: str, home: Home) -> NoReturn:
    """Become the one worker of a station's pool.

    A worker that was killed between taking a flow run and beginning it left it pending, and the
    pool, which carries out one at a time, full: such a run crashes, and its order is given again.
    Raises Unusable for an unknown station, and where Prefect's server does not answer.
    """
    own = dict(os.environ)  # without what `connect` sets for a command that prints its own words
    file_of(station, home)
    pool = pool_of(station)
    give_up_pending(pool, home)
    order_queue.submit(home)
    words = ("worker", "start", "--pool", pool, "--type", "process", "--name", station)
    os.execve(sys.executable, [sys.executable, "-m", "prefect", *words], own)
