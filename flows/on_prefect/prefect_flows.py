"""The orders as Prefect flows, with results and certificates as artifacts.

A deployment takes the order as its parameter, which Prefect validates. Import this module only
after `flows.on_prefect.prefect_server.connect`.
"""

from collections.abc import Callable
from copy import copy
from datetime import UTC, datetime, timedelta
from functools import partial, wraps
from typing import TYPE_CHECKING, Any

from prefect import Flow, flow
from prefect.context import FlowRunContext
from prefect.settings import PREFECT_FLOWS_HEARTBEAT_FREQUENCY, temporary_settings

from flows import logs, run_orders
from flows.on_prefect import run_names
from flows.on_prefect.artifacts import (
    ProgressArtifact,
    show,
    show_certificate,
    show_changes,
    show_discrepancy,
    show_due,
    show_items,
    show_review,
)
from flows.on_prefect.hooks import free_station
from flows.on_prefect.lasting_output import lasting_output
from flows.on_prefect.late_runs import one_of_those_due
from flows.on_prefect.prefect_queue import POOL, pool_of
from flows.orders import order_queue
from flows.orders.production import station_of
from flows.orders.signed_orders import accepted
from schemas.base import BrokenOff, Unusable
from schemas.calibration import Calibration
from schemas.certificate_orders import ProduceOrder
from schemas.history import Reprocessing
from schemas.orders import (
    AlertOrder,
    CalibrateOrder,
    OrderModel,
    RemindOrder,
    ReprocessOrder,
    SubmitOrder,
)
from schemas.recall import DueUnit
from storage.catalogue import run_index
from tasks.stages import alert as alerting
from tasks.stages import remind as reminding
from tasks.stages.stage import without_loss

if TYPE_CHECKING:
    from tasks.stages.published import Published

logs.set_up()  # a worker's process comes in here, and not by the command line

Show = Callable[[Any], None]


def run_now(named: Flow[..., Any], order: OrderModel) -> Any:
    """Run a flow in this process, from its main thread, and return its result.

    Without its heartbeat, whose thread makes every synchronous flow run wait for a second (prefect
    3.8).
    """

    def with_body(body: Callable[..., Any]) -> Flow[..., Any]:
        flow_ = copy(named)
        flow_.fn = body
        return flow_

    with temporary_settings({PREFECT_FLOWS_HEARTBEAT_FREQUENCY: None}):
        return without_loss(named.fn, with_body)(order)


@flow(
    name="produce",
    flow_run_name=run_names.of_acquisition,
    on_crashed=[free_station],
    on_cancellation=[free_station],
)
@one_of_those_due
def produce(order: ProduceOrder) -> "tuple[Published, ...]":
    """Acquire a run from a station, estimate every item, decide, and draft each unit's certificate.

    Raises BrokenOff for units that were abandoned or have no certificate, once the others have
    theirs.
    """
    with lasting_output(), accepted("produce", order):
        context = FlowRunContext.get()
        pool = context and context.flow_run and context.flow_run.work_pool_name
        station = station_of(order, run_orders.home_of(order)).station.id
        if pool and pool.startswith(POOL) and pool != pool_of(station):
            raise Unusable(
                f"the order is for station {station}, and this worker is one of pool {pool}: run "
                f"produce/{station}"
            )
        return run_orders.produce(order, lambda draft: show(lambda: show_certificate(draft)))


@flow(name="reprocess")
def reprocess(order: ReprocessOrder) -> Reprocessing:
    """Re-process the results of a selection of runs, and report what changed."""
    report = run_orders.reprocess(order, ProgressArtifact("reprocess"))
    show(lambda: show_changes(report))
    return report


@flow(name="remind", flow_run_name="reminders within {order.within_days} days")
@one_of_those_due
def remind(order: RemindOrder) -> list[DueUnit]:
    """Send the reminders that are due now, and list the units due within so many days.

    Raises BrokenOff if one could not be sent; the next run tries again.
    """
    home, now = run_orders.home_of(order), datetime.now(UTC)
    faults = reminding.remind(home, now)
    due = reminding.due_units(home, now.astimezone().date() + timedelta(days=order.within_days))
    show(lambda: show_due(due, order.within_days))
    if faults:
        raise BrokenOff("; ".join(faults))
    return due


@flow(name="submit", flow_run_name="orders that wait")
@one_of_those_due
def submit(order: SubmitOrder) -> None:
    """Give every order that waits to Prefect, where it has none or lost it.

    It loses an order whose process starts while the server restarts, or whose worker dies before
    the process starts. Raises BrokenOff where one cannot be given.
    """
    if fault := order_queue.submit(run_orders.home_of(order)):
        raise BrokenOff(fault)


@flow(name="alert", flow_run_name="alert")
def alert(order: AlertOrder) -> None:
    """Send a sentence to whoever operates the line; BrokenOff where a channel did not take it."""
    sent = alerting.alert(run_orders.home_of(order), order.sentence)
    if faults := [f"{each.channel}: {each.fault}" for each in sent if each.fault]:
        raise BrokenOff("; ".join(faults))


@flow(name="calibrate", flow_run_name=partial(run_names.of_run, "calibrate"))
def calibrate(order: CalibrateOrder) -> Calibration:
    """Estimate every item that a run (an id, or a path imported on the fly) allows."""
    made = run_orders.calibrate(order)
    show(lambda: show_items(made, run_index.find(made.run, run_orders.home_of(order)).serial))
    return made


def _ordered(
    work: Callable[[Any], Any],
    run_name: "str | Callable[..., str] | None",
    show_answer: Show = lambda _: None,
    name: str = "",
) -> Any:
    """The flow that carries out an order by a function of `run_orders`.

    show_answer: writes the artifacts of the answer, where the server takes them. name: of the flow,
    where it is another.
    """

    # all but the module: the flow is one of this file
    @wraps(work, assigned=("__name__", "__qualname__", "__doc__"))
    def carried_out(order: OrderModel) -> Any:
        with accepted(work.__name__, order):
            answer = work(order)
        show(lambda: show_answer(answer))
        return answer

    body = one_of_those_due(carried_out) if work in SCHEDULED else carried_out
    return flow(name=name or work.__name__, flow_run_name=run_name)(body)


SCHEDULED = (run_orders.review,)  # of those carried out so
acquire = _ordered(run_orders.acquire, run_names.of_acquisition)
acquire.on_crashed(free_station)
acquire.on_cancellation(free_station)
explain = _ordered(run_orders.explain, partial(run_names.of_run, "explain"), show_discrepancy)
review = _ordered(run_orders.review, None, show_review)
next_recording = _ordered(run_orders.next_recording, "next recording of {order.runs}", name="next")
simulate = _ordered(run_orders.simulate, partial(run_names.of_run, "simulate"))
apply = _ordered(run_orders.apply, "apply {order.calibration} to {order.run}")
certify = _ordered(run_orders.certify, partial(run_names.of_run, "certify"), show_certificate)
check = _ordered(run_orders.check, "check {order.certificate}")
issue = _ordered(run_orders.issue, "issue {order.certificate}", show_certificate)
amend = _ordered(run_orders.amend, "amend {order.certificate}", show_certificate)
withdraw = _ordered(run_orders.withdraw, "withdraw {order.certificate}")
