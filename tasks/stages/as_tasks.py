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


def _is_passing(task_: Task[..., Any], run: TaskRun, state: State[Any]) -> bool:
    """Whether what failed may succeed if it is tried again: a busy database."""
    return isinstance(state.result(raise_on_failure=False), OperationalError)


acquire_run = task(record.acquire_run, name="acquire", cache_policy=NO_CACHE)
take_in = task(
    record.take_in, name="take in", cache_policy=NO_CACHE,
    retries=2, retry_delay_seconds=1, retry_condition_fn=_is_passing,
)  # fmt: skip
estimate_items = task(
    estimate.estimate, name="estimate", cache_policy=NO_CACHE,
    retries=2, retry_delay_seconds=1, retry_condition_fn=_is_passing,
)  # fmt: skip
publish = task(
    certify.certify, name="decide and publish", cache_policy=NO_CACHE,
    retries=2, retry_delay_seconds=1, retry_condition_fn=_is_passing,
)  # fmt: skip
