"""The queue of the named Prefect server; its own client would take seconds to start."""

import os
import time
from functools import lru_cache

import httpx
from pydantic import ValidationError

from flows.prefect_server import server_named
from schemas.pages.line import Queue, Queued

WAITING = ("PENDING", "SCHEDULED", "RUNNING", "PAUSED")
MOST = 50
TIMEOUT_S = 2.0
FRESH_S = 2.0  # for all who look at the page


def queue() -> Queue:
    """The flow runs that wait or run, the next one first; none where no server is named."""
    if not server_named():
        return Queue(server=False)
    return _asked(os.environ["PREFECT_API_URL"], int(time.monotonic() / FRESH_S))


@lru_cache(maxsize=1)
def _asked(url: str, _: int) -> Queue:
    asked = {
        "flow_runs": {"state": {"type": {"any_": WAITING}}},
        "sort": "EXPECTED_START_TIME_ASC",
        "limit": MOST,
    }
    try:
        answer = httpx.post(f"{url.rstrip('/')}/flow_runs/filter", json=asked, timeout=TIMEOUT_S)
        answer.raise_for_status()
        waiting = tuple(
            Queued(
                name=run["name"], state=run["state_name"], expected_at=run["expected_start_time"]
            )
            for run in answer.json()
        )
    except (httpx.HTTPError, httpx.InvalidURL, ValueError, KeyError, TypeError) as error:
        why = "ValidationError" if isinstance(error, ValidationError) else str(error)
        return Queue(server=True, fault=f"Prefect's server did not answer ({why})")
    return Queue(server=True, waiting=waiting)
