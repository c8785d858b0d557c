"""Carries out production orders, each once: from the claim to the drafts of its certificates.

A station carries out one order at a time. One whose process died goes on where it was: with the
certificate where its run is in the store, with the run where that was interrupted.
"""

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from secrets import token_hex
from typing import TYPE_CHECKING, Any

from sqlalchemy import Connection

from flows import execute
from flows.on_prefect.server import server_named
from flows.orders.signed_orders import flow_run
from schemas.base import BrokenOff, Unusable
from schemas.orders import ENDED as ORDER_ENDED
from schemas.orders import (
    OPEN,
    AcquireOrder,
    OrderedUnit,
    OrderRequest,
    ProduceOrder,
    ProductionOrder,
    ProductionState,
)
from schemas.recording import ENDED, Unit
from schemas.station import StationFile
from storage import settings
from storage.catalogue import audit_trail, database, orders
from storage.catalogue.database import Busy
from storage.home import Home
from storage.stations import (
    file_named,
    file_of,
    is_running,
    lockout_of,
    no_order_at,
    one_order_at,
    only_worker_of,
    statuses,
)
from storage.whole_files import writing_in_home
from tasks.stages.acquire import left_runs, procedure_named
from tasks.stages.certificate_inputs import check_order, day_of_moment, read_inputs
from tasks.stages.remind import alert
from tasks.stages.store import ready_to_acquire
from tasks.station.drivers.backend import OTHER_UNIT, confirm
from tasks.words import Message, Sayable, argument, cause_of, clauses, message

if TYPE_CHECKING:
    from tasks.stages.certify import Published

# What became of an order, said once to whoever operates the line.


LINE = "line"  # the person of what the program itself enters in the trail
UNSENT = "alert not sent"
RECENT = timedelta(days=1)  # an older outcome is no news
LATE = timedelta(minutes=15)  # a person mounts a unit, a computer starts, within that


def tell(home: Home) -> None:
    """Alert the operators to every outcome that they were not alerted to yet.

    Those are orders that failed or were refused, and the next order of a station that nothing takes
    although nothing runs there. Whoever comes here first alerts, and the trail says so.
    """
    now = datetime.now(UTC)
    with suppress(Unusable):  # without the catalogue nobody knows what was said
        for order in failed_since(now - RECENT, home):
            outcome = "failed" if order.attempts else "refused"
            say_once(order, outcome, shown_cause(order), home)
        for order in _never_begun(now, home):
            say_once(order, "never-begun", message("order-outcome.nothing-takes-it"), home)


def say_once(order: ProductionOrder, outcome: str, cause: Sayable, home: Home) -> None:
    """Alert the operators, where the home names any and nobody did it for this attempt before.

    A channel by which it could not be sent is tried once more, by whoever comes next.
    """
    asked = settings.reminders(home)
    if asked is None or asked.operators is None:
        return
    about: dict[str, Any] = {"outcome": outcome, "attempt": order.attempts}
    with database.changing(home) as connection:
        due = [
            channel
            for channel in asked.operators.channels
            if _is_due(connection, order.number, **about, channel=channel)
        ]
    sent = alert(home, sentence_of(order, outcome, cause), only=due) if due else []
    if unsent := [each.channel for each in sent if each.fault]:
        with database.changing(home) as connection:
            for channel in unsent:
                audit_trail.add(connection, LINE, UNSENT, order.number, **about, channel=channel)


def _is_due(connection: Connection, number: str, **alert_: Any) -> bool:
    """Whether an alert is to be sent by a channel now, of which the trail has that it was."""
    if audit_trail.add_once(connection, LINE, "alert", number, **alert_):
        return True
    again = audit_trail.has(connection, UNSENT, number, **alert_)
    return again and audit_trail.add_once(connection, LINE, "alert again", number, **alert_)


def failed_since(moment: datetime, home: Home) -> list[ProductionOrder]:
    """The orders that failed since then, of the last ones."""
    states: tuple[ProductionState, ...] = ("failed",)
    failed = orders.listed(home, states=states, last=orders.MANY)
    return [each for each in failed if each.ended_at and each.ended_at > moment]


def sentence_of(order: ProductionOrder, outcome: str, cause: Sayable) -> Message:
    """Which order of which unit, what became of it on which station, why, and what to do."""
    about = {"number": order.number, "unit": order.serials, "station": order.station}
    minutes = f"{LATE.total_seconds() / 60:.0f}"
    return message(f"order-outcome.{outcome}", **about, minutes=minutes, cause=cause)


def shown_cause(order: ProductionOrder) -> Sayable:
    """Why an order failed, or does not begin, as pages and alerts show it."""
    return order.cause or cause_of(order.fault or "")


def _never_begun(now: datetime, home: Home) -> Iterator[ProductionOrder]:
    """The next order of each station where none is carried out, or kept from beginning."""
    next_of: dict[str, ProductionOrder | None] = {}
    for each in orders.listed(home, states=OPEN):
        next_of.setdefault(each.station, each)
        if each.state == "running" or each.fault:
            next_of[each.station] = None
    for order in filter(None, next_of.values()):
        last = orders.listed(home, order.station, ORDER_ENDED, last=1)
        ended = [each.ended_at for each in last if each.ended_at]
        is_late = now - max((order.ordered_at, *ended)) > LATE
        if is_late and not lockout_of(order.station, home):
            yield order


# The queue of each station: orders are checked, kept, and given to what carries them out.
#
# That is a Prefect server where PREFECT_API_URL names one, else a process of the command line,
# `mimucal station work`, which takes the orders of a station one by one.

# Settings of every unit of a model at the station, which an order does not repeat.
SET_UP = ("rate_range_deg_s", "accel_range_g", "output_rate_hz", "bandwidth_hz")

_started: list["subprocess.Popen[bytes]"] = []  # workers that this process began


@dataclass(frozen=True)
class QueuedOrder:
    """An order of the queue. is_new: whether it was not there before. fault: why nothing can carry
    it out just now; it waits, and the next order that is given tries again.
    """

    order: ProductionOrder
    is_new: bool
    fault: str | None = None


def give(request: OrderRequest, person: str, home: Home) -> QueuedOrder:
    """Check an order, keep it, and have it carried out when the station is free.

    An order without a number for units that are in the queue already is the one that is there.
    Raises Unusable for one that cannot be carried out.
    """
    (given,) = give_all([request], person, home)
    return given


def give_all(requests: Sequence[OrderRequest], person: str, home: Home) -> tuple[QueuedOrder, ...]:
    """Orders in their sequence. Raises Unusable, and keeps none, where one cannot be kept."""
    made = [_known_or_new(request, person, home) for request in requests]
    kept = orders.add(made, home)
    fault = submit(home)
    return tuple(QueuedOrder(order, is_new, fault) for order, is_new in kept)


def _known_or_new(request: OrderRequest, person: str, home: Home) -> ProductionOrder:
    order = checked(request, person, home)
    there = None if request.number is not None else orders.same_open(order, home)
    return there or order


def checked(request: OrderRequest, person: str, home: Home) -> ProductionOrder:
    """The order that is asked for, as it is to be kept.

    Raises Unusable for an unknown station or procedure, another number of units than the station
    has places, a client's order of the future, and what a person at the station would be asked.
    """
    now, procedure = datetime.now(UTC), request.procedure
    if Path(procedure).suffix in settings.READERS:  # it is carried out from another folder
        procedure = str(Path(procedure).absolute())
    file = file_of(request.station, home)
    station = settings.read(file, StationFile)
    # What an order does not say of a unit, the station file says of the one at its place.
    places = [each.unit for each in station.per_unit()]
    units = tuple(
        _unit(unit, places[min(number, len(places) - 1)])
        for number, unit in enumerate(request.units)
    )
    run = AcquireOrder(
        home=str(home.path), station=str(file), procedure=procedure, units=units,
        attended=False, by=person,
    )  # fmt: skip
    execute.check_acquisition(run)
    check_order(request.client_order, None, day_of_moment(now))
    return ProductionOrder(
        number=request.number or new_order_number(now), station=request.station, units=units,
        procedure=procedure, client_order=request.client_order, person=person,
        ordered_at=now,
    )  # fmt: skip


def new_order_number(now: datetime) -> str:
    """A number for an order that has none."""
    return f"{now:%Y%m%d-%H%M%S}-{token_hex(3)}"


def _unit(ordered: OrderedUnit, there: Unit) -> Unit:
    names = {
        "manufacturer": ordered.manufacturer or there.manufacturer,
        "model": ordered.model or there.model,
        "serial": ordered.serial,
    }
    extra = there.model_extra or {}
    is_its_model = (names["manufacturer"], names["model"]) == (there.manufacturer, there.model)
    set_up = {name: extra[name] for name in SET_UP if name in extra} if is_its_model else {}
    return Unit.model_validate(names | set_up)


def submit(home: Home) -> str | None:
    """Give every order that waits to what carries it out; why that is not possible just now.

    An order whose process died waits again.
    """
    requeue_orphans(home)
    tell(home)
    waiting = orders.waiting(home)
    if not waiting:
        return None
    if server_named():
        from flows.on_prefect import queue

        return queue.submit(waiting, home)
    for station in {order.station for order in waiting}:
        start_worker(station, home)
    return None


def cancel(number: str, person: str, home: Home) -> ProductionOrder:
    """Cancel an order that waits, here and at Prefect; raises Unusable for any other."""
    requeue_orphans(home)
    flow_run = orders.find(number, home).flow_run
    cancelled = orders.cancel(number, person, home)
    if flow_run and server_named():
        from flows.on_prefect import queue

        queue.cancel(flow_run, home)
    return cancelled


def retry(number: str, person: str, home: Home, reason: str | None = None) -> QueuedOrder:
    """Have an order carried out again that failed or was cancelled.

    A run it began goes on; after an invalid one its units are measured again.
    """
    left = requeue_orphans(home)
    if any(each.number == number for each in left):
        order = orders.find(number, home)  # it waits again already
    else:
        order = orders.retry(number, person, home, reason)
    return QueuedOrder(order, is_new=False, fault=submit(home))


def requeue_orphans(home: Home, *, here: bool = False) -> list[ProductionOrder]:
    """Have every order wait again whose process died, whoever that was; returns them.

    On this computer the process is looked for, and the lock of its station's orders; of another
    one Prefect knows whether the flow run has ended, and the run's status whether it goes on.
    here: whether only those of this computer are looked at.
    """
    host = socket.gethostname()
    begun = orders.running(home)
    away = [each for each in begun if each.host != host and each.flow_run]
    if away and not here and server_named():
        from flows.on_prefect import queue

        alive = {status.station for status, is_dead in statuses(home)
                 if status.state not in ENDED and not is_dead}  # fmt: skip
        ended = queue.ended([each for each in away if each.station not in alive], home)
    else:
        ended = []
    left = [each for each in begun if each.host == host and not is_running(each.process)]
    taken = []
    for order in left:
        with no_order_at(order.station, home) as is_free:
            if is_free and orders.wait_again(order, home):
                taken.append(order)
    return taken + [each for each in ended if orders.wait_again(each, home)]


def start_worker(station: str, home: Home) -> None:
    """Begin a process that takes the orders of a station, and outlives this one.

    Where one takes them already, the new one sees it and ends.
    """
    _started[:] = [process for process in _started if process.poll() is None]
    log = log_of(station, home)
    with writing_in_home(log), log.open("ab") as output:
        process = subprocess.Popen(
            [sys.executable, "-P", "-m", "flows.cli", "station", "work", station],
            stdin=subprocess.DEVNULL, stdout=output, stderr=output, start_new_session=True,
            env=os.environ | {"MIMUCAL_HOME": str(home.path)},
        )  # fmt: skip
    _started.append(process)


def log_of(station: str, home: Home) -> Path:
    """What the process that takes a station's orders writes."""
    name = "".join(sign if sign.isalnum() or sign in "-_." else "_" for sign in station)
    return home.path / "orders" / f"station-{name}.log"


def client_orders_of(home: Home) -> tuple[str, ...]:
    """The clients' orders (mimu-order/1) that a home offers, by the names of their files."""
    found = (path.name for path in client_order_folder(home).glob("*"))
    return tuple(sorted(name for name in found if Path(name).suffix in settings.READERS))


def client_order_folder(home: Home) -> Path:
    """Where they lie."""
    return home.path / "client-orders"


SCHEDULE = "schedule"  # the person of an order that nobody gave
LOOK_S = 1.0  # between two checks of what prevents an order from starting
SECOND = timedelta(seconds=1)  # resolution of a recording's start time


@dataclass(frozen=True)
class Production:
    """What is being carried out. order: of the run and the certificate, with what the queue says of
    it. runs: those that are in the store already, after which only the certificates are missing.
    drafts: those that were made.
    """

    kept: ProductionOrder
    order: ProduceOrder
    runs: tuple[str, ...]
    home: Home
    drafts: "list[Published]" = field(default_factory=list)

    def note_draft(self, draft: "Published") -> None:
        """The certificate of one of its units is there."""
        self.drafts.append(draft)
        numbers = tuple(each.certificate.number for each in self.drafts)
        orders.note(self.kept.number, self.home, certificates=numbers)

    def note_runs(self, runs: tuple[str, ...]) -> None:
        """From now on this order measures nothing again."""
        orders.note(self.kept.number, self.home, runs=runs)


Work = Callable[[Production], "tuple[Published, ...]"]


def carry_out(order: ProduceOrder, work: Work) -> "tuple[Published, ...]":
    """Do the work of an order of the queue, once it can begin; its drafts.

    While its units are not mounted, orders whose units are come first. An order without a number,
    as of a schedule, is the next one of the station's queue; where that is empty, one of its own
    for the units of the station file. Nothing is done of one that waits no more. Raises Unusable
    for an order of another station, and what the work raises; the order has then failed.
    """
    home = execute.home_of(order)
    station = station_of(order, home)
    if order.number is not None:
        ordered = orders.find(order.number, home).station
        if ordered != station.station.id:
            raise Unusable(
                f"order {order.number} is for station {ordered}, and this is "
                f"{station.station.id}: let a worker of {ordered} take it"
            )
    with one_order_at(station.station.id, home):
        left = orders.put_back(station.station.id, home)
        queue = [] if order.number else orders.waiting(home, station.station.id)
        number = order.number or (queue[0].number if queue else _own_order(order, station, home))
        is_of_queue = bool(order.number or queue)
        while True:
            ready = _next_to_begin(number, station, home, is_of_queue=is_of_queue)
            kept = orders.claim(ready, home)
            if left:  # not before the claim: one of them may be this order
                submit(home)
                left = []
            if ready == number:
                return _finished(kept, order, station, home, work) if kept else ()
            if kept:
                _carried_out_before(kept, order, station, home, work)


def produce(
    order: ProduceOrder, drafted: "Callable[[Published], object]" = lambda _: None
) -> "tuple[Published, ...]":
    """Acquire a run from a station, estimate every item, decide, and draft each unit's certificate.

    drafted: called with each draft. Raises BrokenOff for units that were abandoned or have no
    certificate, once the others have theirs.
    """
    return carry_out(order, partial(_produced, drafted=drafted))


def _produced(
    production: Production, drafted: "Callable[[Published], object]"
) -> "tuple[Published, ...]":
    order, runs = production.order, production.runs
    inputs = read_inputs(order)  # bad files are refused before it turns
    faults: list[Unusable] = []
    if not runs:
        usual = inputs.laboratory.operator if inputs.laboratory else None
        acquired = execute.acquire(order.model_copy(update={"by": order.by or usual}))
        runs = tuple(run.id for run, _ in acquired.kept)
        faults += acquired.given_up
        production.note_runs(runs)
    for run in runs:
        try:
            draft = execute.certify(order.certify(run))
        except Unusable as fault:
            faults.append(fault)
        else:
            production.note_draft(draft)
            drafted(draft)
    if faults:
        sentence = "; ".join(str(fault).rstrip(".") for fault in faults)
        cause = clauses([cause_of(fault) for fault in faults], "station-cause.and")
        raise BrokenOff(sentence, cause)
    return tuple(production.drafts)


def _carried_out_before(
    kept: ProductionOrder, order: ProduceOrder, station: StationFile, home: Home, work: Work
) -> None:
    """Another order whose units are mounted; its failure is its own, unless it was a stop."""
    try:
        _finished(kept, order, station, home, work)
    except Unusable:
        return
    except BrokenOff as fault:
        if fault.__cause__ is not None:  # a stop, or a full disk
            raise


def _next_to_begin(number: str, station: StationFile, home: Home, *, is_of_queue: bool) -> str:
    """The number of an order, once nothing keeps it from beginning or it waits no more; that of
    another one whose units are mounted in the place of its own. It says what keeps it.

    is_of_queue: whether somebody is expected to mount its units; else they are those of the
    station file, and others are refused.
    """
    began = datetime.now(UTC)
    while True:
        with suppress(Busy):
            kept = orders.find(number, home)
            hindrance = _blocked_by(kept, station, home, is_of_queue)
            if kept.state != "waiting" or hindrance is None:
                return number
            if other := _mounted_instead(hindrance, station, home):
                return other
            if str(hindrance) != kept.fault:
                orders.note(number, home, fault=str(hindrance), cause=cause_of(hindrance))
            if datetime.now(UTC) - began > LATE:
                say_once(kept, "waits", cause_of(hindrance), home)
        time.sleep(LOOK_S)


def _mounted_instead(hindrance: Unusable, station: StationFile, home: Home) -> str | None:
    """The number of the next order of the unit that is mounted in the place of another."""
    if not (isinstance(hindrance.cause, Message) and hindrance.cause.id == OTHER_UNIT):
        return None
    mounted = str(argument(hindrance.cause, "found"))
    for each in orders.waiting(home, station.station.id):
        is_of_it = mounted in (unit.serial for unit in each.units)
        if is_of_it and _blocked_by(each, station, home, is_of_queue=True) is None:
            return each.number
    return None


def _blocked_by(
    kept: ProductionOrder, station: StationFile, home: Home, is_of_queue: bool
) -> Unusable | None:
    """Why an order cannot begin just now."""
    id_ = station.station.id
    if kept.runs:  # which needs no station
        return None
    if stop := lockout_of(id_, home):
        locked_out = message("station-cause.locked-out", name=stop.by, station=id_)
        return Unusable(f"station {id_} was stopped by {stop.by}: release it", locked_out)
    try:
        ready_to_acquire(id_, home)
        if is_of_queue:
            for each in station.with_units(kept.units).per_unit():
                confirm(each.unit, each.unit_link)
    except Unusable as fault:
        return fault
    return None


def station_of(order: ProduceOrder, home: Home) -> StationFile:
    """The station of an order, by its file or its id."""
    return settings.read(file_named(order.station, home), StationFile)


def _own_order(order: ProduceOrder, station: StationFile, home: Home) -> str:
    """The record of an order that nobody gave; its number."""
    now = datetime.now(UTC)
    units = order.units or tuple(each.unit for each in station.per_unit())
    made = ProductionOrder(
        number=new_order_number(now), station=station.station.id, units=units,
        procedure=order.procedure, person=order.by or SCHEDULE, ordered_at=now,
        flow_run=flow_run(),
    )  # fmt: skip
    orders.add([made], home)
    return made.number


def _production(
    kept: ProductionOrder, order: ProduceOrder, station: StationFile, home: Home
) -> Production:
    """What is left to be done of an order that was claimed."""
    runs = kept.runs
    if not runs and kept.is_interrupted:
        runs = orders.stored_since(kept, home)
    own: dict[str, Any] = {
        "number": kept.number, "units": kept.units, "procedure": kept.procedure,
        "client_order": kept.client_order or order.client_order,
        "by": order.by if kept.person == SCHEDULE else kept.person,
        "resume": not runs and kept.is_interrupted and _is_left(kept, station, home),
    }  # fmt: skip
    return Production(kept, order.model_copy(update=own), runs, home)


def _is_left(kept: ProductionOrder, station: StationFile, home: Home) -> bool:
    """Whether every unit of an order has an interrupted run that began for this order."""
    assert kept.began_at is not None
    try:
        left = left_runs(station.with_units(kept.units), procedure_named(kept.procedure), home)
    except Unusable:
        return False
    began = [
        datetime.fromisoformat(str((run.recording.manifest.model_extra or {})["recorded_at"]))
        for run in left.values()
    ]
    return len(began) == len(kept.units) and min(began) + SECOND > kept.began_at


def _finished(
    kept: ProductionOrder, order: ProduceOrder, station: StationFile, home: Home, work: Work
) -> "tuple[Published, ...]":
    try:
        drafts = work(_production(kept, order, station, home))
    except BaseException as fault:
        with suppress(Busy):  # then whoever comes next finds that this process ended
            sentence = str(fault) or type(fault).__name__
            orders.finish(kept.number, "failed", home, sentence, cause_of(fault))
            tell(home)
        raise
    orders.finish(kept.number, "done", home)
    return drafts


def work_at(station: str, home: Home, report: Callable[[ProductionOrder], None]) -> bool:
    """Take the orders of a station one by one until none waits; False where another process does.

    An order that fails keeps none after it from being taken, unless it was stopped: then BrokenOff
    says that the others wait.
    """
    file = file_of(station, home)
    while True:
        with only_worker_of(station, home) as is_alone:
            if not is_alone:
                return False
            with one_order_at(station, home):
                orders.put_back(station, home)
            while waiting := orders.waiting(home, station):
                _take(waiting[0].number, file, home)
                report(orders.find(waiting[0].number, home))
        if not orders.waiting(home, station):  # given while this process was about to end
            return True


def _take(number: str, file: Path, home: Home) -> None:
    """Carry out one order; raises what kept it from being begun, which the next would meet too."""
    order = ProduceOrder(home=str(home.path), station=str(file), number=number, attended=False)
    try:
        produce(order)
    except (Unusable, BrokenOff) as fault:
        if isinstance(fault, BrokenOff) and fault.__cause__ is not None:  # a stop, or a full disk
            raise BrokenOff(
                f"{fault}; `mimucal order retry {number}` goes on with it, and `mimucal station "
                "work` takes the orders that wait"
            ) from fault
        if orders.find(number, home).state == "waiting":
            raise
