"""Catching up: of the overdue runs of a schedule, only the newest is carried out."""

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
MISSED: State[Any] = Cancelled(
    message="a newer run of the same schedule is due: it does what this one would"
)


def newest_only(body: Callable[..., Any]) -> Callable[..., Any]:
    """The body of a flow, carried out unless a newer run of the same schedule is due.

    Runs that somebody ordered are always carried out.
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
        return bool(_cancel_older(run, run.deployment_id))
    return False


def _cancel_older(run: FlowRun, deployment: "UUID") -> list[FlowRun]:
    """Cancels what waits and is not the newest; gives what is newer than this run."""
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
        newest = max((*others, run), key=_due_at)
        for each in others:
            is_waiting = each.state_type is StateType.SCHEDULED
            if is_waiting and each.id != newest.id:
                client.set_flow_run_state(each.id, MISSED)
    return [each for each in others if _due_at(each) > _due_at(run)]


def _due_at(run: FlowRun) -> datetime:
    return run.expected_start_time or datetime.min.replace(tzinfo=UTC)
