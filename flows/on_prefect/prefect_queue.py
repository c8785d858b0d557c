"""Orders as flow runs of a Prefect server: one of `produce/STATION` for each."""

from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING, Any
from uuid import UUID

from flows.on_prefect.client import prefect_client
from flows.on_prefect.prefect_server import connect
from schemas.base import Unusable
from schemas.production import ProductionOrder
from storage.catalogue import orders
from storage.home import Home
from tasks.words import cause_of

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from prefect.client.orchestration import SyncPrefectClient
    from prefect.client.schemas.objects import State

MOST = 200  # flow runs that the server gives in one answer
LINE = "line"  # the pool of what needs no station
WAITS = "the order waits, and is given to it with the next one"
TRIED = 3  # flow runs of an order that fail before they take it, after which it is refused
POOL = "station-"  # how the names of the stations' work pools begin
# A worker that is killed between taking a flow run and starting it leaves it pending forever, and
# the pool of its station full. With all cores busy a process takes a minute to start.
BEGINS_WITHIN = timedelta(minutes=5)


def submit(waiting: Sequence[ProductionOrder], home: Home) -> str | None:
    """A flow run for each order that has none, or one that ended before it took the order.

    Why some have none yet, as a sentence.
    """
    faults = {}
    try:
        with _client(home) as client:
            _crash_pending(client, BEGINS_WITHIN)
            alive = _alive([order.flow_run for order in waiting if order.flow_run], client)
            for order in waiting:
                if order.flow_run not in alive and not _is_refused(order, client, home):
                    faults[order.station] = _submitted(order, client, home)
    except Unusable as fault:
        return str(fault)
    return "; ".join(filter(None, faults.values())) or None


def _alive(flow_runs: Sequence[str], client: "SyncPrefectClient") -> set[str]:
    """Those of some flow runs that have not ended."""
    from prefect.client.schemas.filters import FlowRunFilter, FlowRunFilterId

    found = set()
    for at in range(0, len(flow_runs), MOST):
        ids = [UUID(each) for each in flow_runs[at : at + MOST]]
        asked = FlowRunFilter(id=FlowRunFilterId(any_=ids))
        for run in client.read_flow_runs(flow_run_filter=asked, limit=MOST):
            if run.state is None or not run.state.is_final():
                found.add(str(run.id))
    return found


def _is_refused(order: ProductionOrder, client: "SyncPrefectClient", home: Home) -> bool:
    """Ends an order whose flow runs fail again and again before they take it."""
    from prefect.exceptions import ObjectNotFound

    if order.submissions < TRIED or order.flow_run is None:
        return False
    with suppress(ObjectNotFound):
        state = client.read_flow_run(UUID(order.flow_run)).state
        if state is not None and state.is_failed():
            fault = state.message or state.name or ""
            return orders.finish(
                order.number, "failed", home, fault, cause_of(fault), was="waiting"
            )
    return False


def ended(begun: Sequence[ProductionOrder], home: Home) -> list[ProductionOrder]:
    """Orders of other computers whose flow run ended without ending them; none of a server that
    does not answer.
    """
    with suppress(Unusable), _client(home) as client:
        alive = _alive([str(order.flow_run) for order in begun], client)
        return [order for order in begun if order.flow_run not in alive]
    return []


def give_up_pending(pool: str, home: Home) -> None:
    """Have the flow runs of a pool crash that its worker, now dead, took and did not begin."""
    with _client(home, "then start the worker again") as client:
        _crash_pending(client, timedelta(), pool)


def _crash_pending(client: "SyncPrefectClient", least: timedelta, pool: str | None = None) -> None:
    """Crash the flow runs, of a pool or of all, that have been pending for at least so long."""
    from prefect.client.schemas.filters import (
        FlowRunFilter,
        FlowRunFilterState,
        FlowRunFilterStateType,
        WorkPoolFilter,
        WorkPoolFilterName,
    )
    from prefect.client.schemas.objects import StateType
    from prefect.states import Crashed

    is_pending = FlowRunFilterStateType(any_=[StateType.PENDING])
    found = client.read_flow_runs(
        flow_run_filter=FlowRunFilter(state=FlowRunFilterState(type=is_pending)),
        work_pool_filter=(pool and WorkPoolFilter(name=WorkPoolFilterName(any_=[pool]))) or None,
        limit=MOST,
    )
    for run in found:
        if run.state is not None and datetime.now(UTC) - run.state.timestamp >= least:
            lost: State[Any] = Crashed(message="its worker died before it began")
            client.set_flow_run_state(run.id, lost, force=True)


def pool_of(station: str) -> str:
    """The name of a station's work pool."""
    return f"{POOL}{station}"


def cancel(flow_run: str, home: Home) -> None:
    """Take a flow run back, as well as it can be: what begins all the same finds no order."""
    with suppress(Unusable), _client(home) as client:
        from prefect.exceptions import ObjectNotFound
        from prefect.states import Cancelled

        with suppress(ObjectNotFound):
            client.set_flow_run_state(UUID(flow_run), Cancelled())


def _submitted(order: ProductionOrder, client: "SyncPrefectClient", home: Home) -> str | None:
    """The order as a flow run; why it cannot be one. Twice the same order is one flow run."""
    from prefect.exceptions import ObjectNotFound

    name = f"produce/{order.station}"
    try:
        deployment = client.read_deployment_by_name(name)
    except ObjectNotFound:
        return (
            f"Prefect's server has no deployment {name}: add station {order.station} with "
            "`mimucal station add FILE`; the order waits until then"
        )
    usual = dict((deployment.parameters or {}).get("order") or {})
    run = client.create_flow_run_from_deployment(
        deployment.id,
        parameters={"order": {"station": order.station} | usual | {"number": order.number}},
        name=order.title,
        tags=[order.station, *(unit.serial for unit in order.units)],
        idempotency_key=_key(order),
    )
    orders.note(order.number, home, flow_run=str(run.id), submissions=order.submissions + 1)
    return None


def _key(order: ProductionOrder) -> str:
    """The same for all who give it to the server at the same time."""
    again = f"/{order.submissions}" if order.submissions else ""
    return f"{order.number}{again}"


def _client(home: Home, otherwise: str = WAITS) -> "AbstractContextManager[SyncPrefectClient]":
    """A client of the server; what it does not answer raises Unusable."""
    connect(home)
    return prefect_client(otherwise)
