"""The Prefect workers of a line and of its stations."""

import os
import sys
from typing import NoReturn

from flows.on_prefect.prefect_queue import LINE, give_up_pending, pool_of
from flows.orders import order_queue
from storage.home import Home
from storage.stations import file_of

# For a worker, and for the process of each run. A server that is down for minutes is retried after
# 2 s, 4 s … 256 s; so is one that answers 500, as it does while its database is down.
PATIENT = {
    "PREFECT_CLIENT_MAX_RETRIES": "8",
    "PREFECT_CLIENT_RETRY_EXTRA_CODES": "500",
    "PREFECT_FLOWS_HEARTBEAT_FREQUENCY": "30",  # s; a run without is one that died
    "DO_NOT_TRACK": "1",
    # Prefect 3.9.1 starts a hook by its file, and a file's folder comes first on the import path:
    # `prefect/runner`, whose storage.py would hide our `storage`. With this no folder is added.
    "PYTHONSAFEPATH": "1",
}


def work_for_line(home: Home) -> NoReturn:
    """Become a worker of what needs no station."""
    _become(LINE, LINE, dict(os.environ), home)


def work_at_station(station: str, home: Home) -> NoReturn:
    """Become the one worker of a station's pool.

    A worker that was killed between taking a flow run and beginning it left it pending, and the
    pool, which carries out one at a time, full: such a run crashes, and its order is given again.
    Raises Unusable for an unknown station, and where Prefect's server does not answer.
    """
    own = dict(os.environ)  # without what `connect` sets for a command that prints its own words
    file_of(station, home)
    give_up_pending(pool_of(station), home)
    order_queue.submit(home)
    _become(pool_of(station), station, own, home)


def _become(pool: str, name: str, variables: dict[str, str], home: Home) -> NoReturn:
    """Become a worker, which keeps beside its runs what Prefect would in ~/.prefect."""
    words = ("worker", "start", "--pool", pool, "--type", "process", "--name", name)
    command = [sys.executable, "-m", "prefect", *words]
    own = {"PREFECT_HOME": str(home.station_side / "prefect")}
    os.execve(sys.executable, command, own | PATIENT | variables)
