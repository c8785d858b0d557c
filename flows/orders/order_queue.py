"""The queue of each station: orders are checked, kept, and given to what carries them out.

That is a Prefect server where PREFECT_API_URL names one, else a process of the command line,
`mimucal station work`, which takes the orders of a station one by one.
"""

import os
import socket
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from secrets import token_hex

from flows import run_orders
from flows.on_prefect.prefect_server import server_named
from flows.orders import outcomes
from schemas.orders import AcquireOrder
from schemas.production import OrderedUnit, OrderRequest, ProductionOrder
from schemas.recording import Unit
from schemas.run_log import ENDED
from schemas.station import StationFile
from storage import settings
from storage.catalogue import orders
from storage.home import Home
from storage.order_lock import no_order_at
from storage.station_lock import is_running, statuses
from storage.stations import file_of
from storage.whole_files import writing_in_home
from tasks.stages.certificate_inputs import check_order, day_of_moment

# Settings of every unit of a model at the station, which an order does not repeat.
SET_UP = ("rate_range_deg_s", "accel_range_g", "output_rate_hz", "bandwidth_hz")

_started: list["subprocess.Popen[bytes]"] = []  # workers that this process began


@dataclass(frozen=True)
class GivenProduction:
    """An order of the queue. is_new: whether it was not there before. fault: why nothing can carry
    it out just now; it waits, and the next order that is given tries again.
    """

    order: ProductionOrder
    is_new: bool
    fault: str | None = None


def give(request: OrderRequest, person: str, home: Home) -> GivenProduction:
    """Check an order, keep it, and have it carried out when the station is free.

    An order without a number for units that are in the queue already is the one that is there.
    Raises Unusable for one that cannot be carried out.
    """
    (given,) = give_all([request], person, home)
    return given


def give_all(
    requests: Sequence[OrderRequest], person: str, home: Home
) -> tuple[GivenProduction, ...]:
    """Orders in their sequence. Raises Unusable, and keeps none, where one cannot be kept."""
    made = [_known_or_new(request, person, home) for request in requests]
    kept = orders.add(made, home)
    fault = submit(home)
    return tuple(GivenProduction(order, is_new, fault) for order, is_new in kept)


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
    run_orders.check_acquisition(run)
    check_order(request.client_order, None, day_of_moment(now))
    return ProductionOrder(
        number=request.number or drawn_number(now), station=request.station, units=units,
        procedure=procedure, client_order=request.client_order, person=person,
        ordered_at=now,
    )  # fmt: skip


def drawn_number(now: datetime) -> str:
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
    take_up_left(home)
    outcomes.tell(home)
    waiting = orders.waiting(home)
    if not waiting:
        return None
    if server_named():
        from flows.on_prefect import prefect_queue

        return prefect_queue.submit(waiting, home)
    for station in {order.station for order in waiting}:
        start_worker(station, home)
    return None


def cancel(number: str, person: str, home: Home) -> ProductionOrder:
    """Cancel an order that waits, here and at Prefect; raises Unusable for any other."""
    take_up_left(home)
    flow_run = orders.find(number, home).flow_run
    cancelled = orders.cancel(number, person, home)
    if flow_run and server_named():
        from flows.on_prefect import prefect_queue

        prefect_queue.cancel(flow_run, home)
    return cancelled


def retry(number: str, person: str, home: Home, reason: str | None = None) -> GivenProduction:
    """Have an order carried out again that failed or was cancelled.

    A run it began goes on; after an invalid one its units are measured again.
    """
    left = take_up_left(home)
    if any(each.number == number for each in left):
        order = orders.find(number, home)  # it waits again already
    else:
        order = orders.retry(number, person, home, reason)
    return GivenProduction(order, is_new=False, fault=submit(home))


def take_up_left(home: Home, *, here: bool = False) -> list[ProductionOrder]:
    """Have every order wait again whose process died, whoever that was; returns them.

    On this computer the process is looked for, and the lock of its station's orders; of another
    one Prefect knows whether the flow run has ended, and the run's status whether it goes on.
    here: whether only those of this computer are looked at.
    """
    host = socket.gethostname()
    begun = orders.running(home)
    away = [each for each in begun if each.host != host and each.flow_run]
    if away and not here and server_named():
        from flows.on_prefect import prefect_queue

        alive = {status.station for status, is_dead in statuses(home)
                 if status.state not in ENDED and not is_dead}  # fmt: skip
        ended = prefect_queue.ended([each for each in away if each.station not in alive], home)
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
