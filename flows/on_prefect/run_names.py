"""Names of flow runs: what it is done to, and how, as the people at the station call it.

Import this module only after `flows.on_prefect.prefect_server.connect`.
"""

from contextlib import suppress
from pathlib import Path

from prefect.runtime import flow_run

from flows.run_orders import home_of
from schemas.base import Unusable
from schemas.orders import AcquireOrder
from schemas.station import StationFile
from storage import settings
from storage.catalogue import orders, run_index
from storage.stations import file_named


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
        found = run_index.find(order.run, home_of(order))
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
