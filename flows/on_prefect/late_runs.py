"""Catching up: of the overdue runs of a schedule, one is carried out."""

from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from functools import wraps
from typing import TYPE_CHECKING, Any

from httpx import HTTPError
from prefect.client.orchestration import get_client
from prefect.client.schemas.filters import (
    FlowRunFilter,
    FlowRunFilterDeploymentId,
    FlowRunFilterExpectedStartTime,
    FlowRunFilterState,
    FlowRunFilterStateType,
)
from prefect.client.schemas.objects import FlowRun, State, StateType
from prefect.context import FlowRunContext
from prefect.states import Cancelled

if TYPE_CHECKING:
    from uuid import UUID

WAITING_OR_RUNNING = [StateType.SCHEDULED, StateType.PENDING, StateType.RUNNING]
MISSED: State[Any] = Cancelled(message="another run of the same schedule does what this one would")


def one_of_those_due(body: Callable[..., Any]) -> Callable[..., Any]:
    """The body of a flow, carried out for all runs of its schedule that are due and wait, which are
    cancelled; not at all where a newer one was taken.

    Whichever begins carries it out: one that gave way to those that wait would never be carried out
    where a run begins later than its schedule repeats. Runs that somebody ordered always are.
    """

    @wraps(body)
    def unless_late(order: Any) -> Any:
        return MISSED if _is_superseded() else body(order)

    return unless_late


def _is_superseded() -> bool:
    context = FlowRunContext.get()
    run = context.flow_run if context else None
    if not isinstance(run, FlowRun) or run.deployment_id is None or not run.auto_scheduled:
        return False
    with suppress(HTTPError):  # no other run is known while the server is down
        return not _cancelled_others(run, run.deployment_id)
    return False


def _cancelled_others(run: FlowRun, deployment: "UUID") -> bool:
    """Cancels what waits; False, and nothing is done, where a newer run was taken."""
    now = datetime.now(UTC)
    due = FlowRunFilter(
        deployment_id=FlowRunFilterDeploymentId(any_=[deployment]),
        state=FlowRunFilterState(type=FlowRunFilterStateType(any_=WAITING_OR_RUNNING)),
        expected_start_time=FlowRunFilterExpectedStartTime.model_validate({"before_": now}),
    )
    with get_client(sync_client=True) as client:
        others = [
            each
            for each in client.read_flow_runs(flow_run_filter=due)
            if each.id != run.id and each.auto_scheduled and each.created_by == run.created_by
        ]
        waiting = [each for each in others if each.state_type is StateType.SCHEDULED]
        if any(_due_at(each) > _due_at(run) for each in others if each not in waiting):
            return False
        for each in waiting:
            client.set_flow_run_state(each.id, MISSED)
    return True


def _due_at(run: FlowRun) -> datetime:
    return run.expected_start_time or datetime.min.replace(tzinfo=UTC)
