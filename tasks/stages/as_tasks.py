"""The Prefect task of each stage. Only these and the flows know Prefect.

A stage that only reads and writes the store is tried again, twice, where the catalogue is
locked by another process or out of reach. The run on a station is not: a unit that has begun
to turn is never turned again by itself.
"""

from typing import Any

from prefect import task
from prefect.cache_policies import NO_CACHE
from prefect.client.schemas.objects import State, TaskRun
from prefect.tasks import Task

from storage.catalogue.connection import Busy
from tasks.stages import plain


def _is_busy(task_: Task[..., Any], run: TaskRun, state: State[Any]) -> bool:
    """Whether the catalogue was locked or out of reach, so that trying again makes sense."""
    return isinstance(state.result(raise_on_failure=False), Busy)


acquire_run = task(name="acquire", cache_policy=NO_CACHE)(plain.acquire_run)
_again: dict[str, Any] = {
    "cache_policy": NO_CACHE,
    "retries": 2,
    "retry_delay_seconds": 1,
    "retry_condition_fn": _is_busy,
}
take_in = task(name="take in", **_again)(plain.take_in)
estimate_items = task(name="estimate", **_again)(plain.estimate_items)
adopt_terms = task(name="estimate with terms", **_again)(plain.adopt_terms)
explain_run = task(name="explain", **_again)(plain.explain_run)
simulate_run = task(name="simulate", **_again)(plain.simulate_run)
publish = task(name="decide and publish", **_again)(plain.publish)
