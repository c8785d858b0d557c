"""What Prefect calls when a run of a station crashed or was cancelled."""

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from schemas.base import Unusable
from schemas.station import StationFile
from storage import settings
from storage.home import Home, home
from storage.station_lock import statuses, write_status

if TYPE_CHECKING:
    from prefect.client.schemas.objects import FlowRun
    from prefect.states import State


def free_station(flow: Any, flow_run: "FlowRun", state: "State[Any]") -> None:
    """Has the station of a run stopped, and its status say how it ended."""
    order = flow_run.parameters.get("order", {})
    place = Home(Path(order["home"])) if order.get("home") else home()
    with suppress(Unusable):
        station = settings.read(Path(order.get("station", "")), StationFile).station.id
        stop(station, f"Prefect ({state.name}: {state.message or flow.name})", place)


def stop(station: str, cause: str, place: Home) -> None:
    """A status whose process is dead says that the run stopped, and why."""
    for status, is_dead in statuses(place):
        if status.station == station and is_dead:
            write_status(status.model_copy(update={"state": "stopped", "cause": cause}), place)
