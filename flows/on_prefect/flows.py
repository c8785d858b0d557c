"""The orders as Prefect flows, with results and certificates as artifacts.

A deployment takes the order as its parameter, which Prefect validates. Import this module only
after `flows.on_prefect.server.connect`.
"""

from collections.abc import Callable
from contextlib import suppress
from copy import copy
from datetime import UTC, datetime, timedelta
from functools import partial, wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

from prefect import Flow, flow
from prefect.context import FlowRunContext
from prefect.runtime import flow_run
from prefect.settings import PREFECT_FLOWS_HEARTBEAT_FREQUENCY, temporary_settings

from flows import execute, logs
from flows.execute import home_of
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
from flows.on_prefect.queue import POOL, one_of_those_due, pool_of
from flows.orders import production
from flows.orders.production import station_of
from flows.orders.signed_orders import accepted
from flows.signals import resilient_output
from schemas.base import BrokenOff, Unusable
from schemas.calibration import Calibration
from schemas.history import Reprocessing
from schemas.orders import (
    AcquireOrder,
    AlertOrder,
    CalibrateOrder,
    OrderModel,
    ProduceOrder,
    RemindOrder,
    ReprocessOrder,
    SubmitOrder,
)
from schemas.station import StationFile
from schemas.store import DueUnit
from storage import settings
from storage.catalogue import orders, runs
from storage.home import Home, home
from storage.stations import file_named, statuses
from tasks.stages import remind as reminding
from tasks.stages.stage import without_loss
from tasks.stages.stop import stop_station
from tasks.station.connected_station import CANCELLATION, stopped_by
from tasks.words import statement

if TYPE_CHECKING:
    from prefect.client.schemas.objects import FlowRun
    from prefect.states import State

    from tasks.stages.certify import Published


# What Prefect calls when a run of a station crashed or was cancelled.

CANCELLED_NAMES = ("Cancelling", "Cancelled")


def free_station(flow: Any, flow_run: "FlowRun", state: "State[Any]") -> None:
    """Stops the table of a run whose process died, and records in its status how it ended; its
    order goes back into the queue. A run that is still active at the station is another one, and is
    left alone.
    """
    order = flow_run.parameters.get("order", {})
    place = Home(Path(order["home"])) if order.get("home") else home()
    with suppress(Unusable):
        file = file_named(order.get("station", ""), place)
        station = settings.read(file, StationFile).station.id
        if any(status.station == station and is_dead for status, is_dead in statuses(place)):
            cause = f"Prefect ({state.name}: {state.message or flow.name})"
            stop_station(station, cause, place, lockout=False)
    with suppress(Unusable):
        if state.name in CANCELLED_NAMES:  # what somebody ended does not begin again by itself
            for each in orders.running(place):
                if each.flow_run == str(flow_run.id):
                    shown = statement(stopped_by(CANCELLATION))
                    orders.finish(each.number, "failed", place, shown.en, shown)
        production.submit(place)


# Names of flow runs: what it is done to, and how, as the people at the station call it.


def of_acquisition() -> str:
    """The serial numbers of the mounted units and the procedure; of an order of the queue, its."""
    order = flow_run.parameters["order"]
    with suppress(Unusable):
        if number := getattr(order, "number", None):
            return orders.find(number, home_of(order)).title
    return f"{' + '.join(_serials(order))} {Path(order.procedure).stem}"


def of_run(verb: str) -> str:
    """What is done, the serial number of the unit and the procedure of a run."""
    order = flow_run.parameters["order"]
    with suppress(Unusable):
        found = runs.find(order.run, home_of(order))
        return f"{verb} {found.serial} {found.procedure or found.id}"
    return f"{verb} {order.run}"


def _serials(order: AcquireOrder) -> tuple[str, ...]:
    """Those ordered, else those of the station's file; of one that cannot be read, its name."""
    if order.units:
        return tuple(unit.serial for unit in order.units)
    with suppress(Unusable):
        station = settings.read(file_named(order.station, home_of(order)), StationFile)
        return tuple(alone.unit.serial for alone in station.per_unit())
    return (Path(order.station).stem,)


# The flows.

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
    flow_run_name=of_acquisition,
    on_crashed=[free_station],
    on_cancellation=[free_station],
)
@one_of_those_due
def produce(order: ProduceOrder) -> "tuple[Published, ...]":
    """Acquire a run from a station, estimate every item, decide, and draft each unit's certificate.

    Raises BrokenOff for units that were abandoned or have no certificate, once the others have
    theirs.
    """
    with resilient_output(), accepted("produce", order):
        context = FlowRunContext.get()
        pool = context and context.flow_run and context.flow_run.work_pool_name
        station = station_of(order, execute.home_of(order)).station.id
        if pool and pool.startswith(POOL) and pool != pool_of(station):
            raise Unusable(
                f"the order is for station {station}, and this worker is one of pool {pool}: run "
                f"produce/{station}"
            )
        return production.produce(order, lambda draft: show(lambda: show_certificate(draft)))


@flow(name="reprocess")
def reprocess(order: ReprocessOrder) -> Reprocessing:
    """Re-process the results of a selection of runs, and report what changed."""
    report = execute.reprocess(order, ProgressArtifact("reprocess"))
    show(lambda: show_changes(report))
    return report


@flow(name="remind", flow_run_name="reminders within {order.within_days} days")
@one_of_those_due
def remind(order: RemindOrder) -> list[DueUnit]:
    """Send the reminders that are due now, and list the units due within so many days.

    Raises BrokenOff if one could not be sent; the next run tries again.
    """
    home, now = execute.home_of(order), datetime.now(UTC)
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
    if fault := production.submit(execute.home_of(order)):
        raise BrokenOff(fault)


@flow(name="alert", flow_run_name="alert")
def alert(order: AlertOrder) -> None:
    """Send a sentence to whoever operates the line; BrokenOff where a channel did not take it."""
    sent = reminding.alert(execute.home_of(order), order.sentence)
    if faults := [f"{each.channel}: {each.fault}" for each in sent if each.fault]:
        raise BrokenOff("; ".join(faults))


@flow(name="calibrate", flow_run_name=partial(of_run, "calibrate"))
def calibrate(order: CalibrateOrder) -> Calibration:
    """Estimate every item that a run (an id, or a path imported on the fly) allows."""
    made = execute.calibrate(order)
    show(lambda: show_items(made, runs.find(made.run, execute.home_of(order)).serial))
    return made


def _ordered(
    work: Callable[[Any], Any],
    run_name: "str | Callable[..., str] | None",
    show_answer: Show = lambda _: None,
    name: str = "",
) -> Any:
    """The flow that carries out an order by a function of `flows.execute`.

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


SCHEDULED = (execute.review,)  # of those carried out so
acquire = _ordered(execute.acquire, of_acquisition)
acquire.on_crashed(free_station)
acquire.on_cancellation(free_station)
explain = _ordered(execute.explain, partial(of_run, "explain"), show_discrepancy)
review = _ordered(execute.review, None, show_review)
next_recording = _ordered(execute.next_recording, "next recording of {order.runs}", name="next")
simulate = _ordered(execute.simulate, partial(of_run, "simulate"))
apply = _ordered(execute.apply, "apply {order.calibration} to {order.run}")
certify = _ordered(execute.certify, partial(of_run, "certify"), show_certificate)
check = _ordered(execute.check, "check {order.certificate}")
issue = _ordered(execute.issue, "issue {order.certificate}", show_certificate)
amend = _ordered(execute.amend, "amend {order.certificate}", show_certificate)
withdraw = _ordered(execute.withdraw, "withdraw {order.certificate}")
