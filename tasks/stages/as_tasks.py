"""The Prefect task of each stage. Only these and the flows know Prefect.

A retry makes sense where another process may hold the database, and where a station does not
answer yet; never after a unit has begun to turn, and never on input that cannot be used.
"""

from typing import Any

from prefect import task
from prefect.cache_policies import NO_CACHE
from prefect.client.schemas.objects import State, TaskRun
from prefect.tasks import Task
from sqlalchemy.exc import OperationalError

from tasks.stages import certify, estimate, record


def _is_busy(task_: Task[..., Any], run: TaskRun, state: State[Any]) -> bool:
    """Whether another process held the database, so that trying again makes sense."""
    return isinstance(state.result(raise_on_failure=False), OperationalError)


acquire_run = task(name="acquire", cache_policy=NO_CACHE)(record.acquire_run)
_again: dict[str, Any] = {
    "cache_policy": NO_CACHE,
    "retries": 2,
    "retry_delay_seconds": 1,
    "retry_condition_fn": _is_busy,
}
take_in = task(name="take in", **_again)(record.take_in)
estimate_items = task(name="estimate", **_again)(estimate.estimate)
publish = task(name="decide and publish", **_again)(certify.certify)
