"""What Prefect calls when a run of a station crashed or was cancelled."""

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flows.orders import order_queue
from schemas.base import Unusable
from schemas.station import StationFile
from storage import settings
from storage.catalogue import orders
from storage.home import Home, home
from storage.station_lock import statuses
from storage.stations import file_named
from tasks.stages.stop import stop_station
from tasks.station.stopping import CANCELLATION, stopped_by
from tasks.words import statement

if TYPE_CHECKING:
    from prefect.client.schemas.objects import FlowRun
    from prefect.states import State


CANCELLED = ("Cancelling", "Cancelled")


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
        if state.name in CANCELLED:  # what somebody ended does not begin again by itself
            for each in orders.running(place):
                if each.flow_run == str(flow_run.id):
                    shown = statement(stopped_by(CANCELLATION))
                    orders.finish(each.number, "failed", place, shown.en, shown)
        order_queue.submit(place)
