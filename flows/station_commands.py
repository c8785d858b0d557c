"""The `station` commands: serve the virtual station, check a station, load coefficients."""

import asyncio
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from flows import operating_commands, options
from flows.signals import stopping
from schemas.base import BrokenOff, Unusable
from schemas.text import CONTRACTED, text_fields
from storage.home import home
from tasks.words import say

if TYPE_CHECKING:
    from schemas.orders import ProductionOrder
    from schemas.station import StationFile
    from tasks.station.check_devices import Trial


app = typer.Typer(
    help="Serve a virtual station, check and watch stations, load units.", rich_markup_mode=None
)
USUAL_PORT = 5020

app.command(epilog="Example: mimucal station add station.json --schedule '0 8 * * 1-5'")(
    operating_commands.add
)
app.command(epilog="Example: mimucal station remove VIRTUAL-1")(operating_commands.remove)


@app.command(epilog="Example: mimucal station serve --speed 60")
def serve(
    host: options.Host = "127.0.0.1",
    port: options.Port = USUAL_PORT,
    speed: options.Speed = 1.0,
    fault: options.Faults = None,
    seed: options.Seed = 1,
    ahrs: options.Ahrs = False,
    id_: options.VirtualId = None,
    serial: options.MountedSerial = None,
    station_file: options.StationFile = Path("station.json"),
    truth: options.Truth = None,
) -> None:
    """Serve a virtual station until stopped."""
    from tasks.station.virtual import config as virtual
    from tasks.station.virtual.faults import StationFault
    from tasks.station.virtual.servers import serve

    station = virtual.virtual_station(seed, ahrs)
    label = station.unit.model_copy(update={"label": serial})
    own = id_ or (station.id if port == USUAL_PORT else None)
    station = station.model_copy(update={"id": own, "unit": label})
    faults = [StationFault.parse(text) for text in fault or ()]
    if truth is not None:
        _write(truth, json.dumps(virtual.truth(station), indent=1))

    def ready(file: "StationFile") -> None:
        _write(station_file, file.model_dump_json(indent=1))
        modbus = getattr(file.table, "url", "").removeprefix("socket://")
        print(f"Modbus/TCP {modbus}, unit {file.unit_link.url}")
        print(f"station file {station_file}; Ctrl-C stops the station", flush=True)

    ports = {"modbus_port": port, "unit_port": port + 1 if port else 0}
    try:
        asyncio.run(serve(station, host=host, **ports, speed=speed, faults=faults, ready=ready))
    except KeyboardInterrupt:
        print("station stopped")


@app.command(epilog="Example: mimucal station check station.json")
def check(
    station_file: options.Station, move: options.Move = False, as_json: options.Json = False
) -> None:
    """Test every device of a station file and report what works. Exits with 1 on any failure."""
    from flows.terminal import print_json, print_rows
    from schemas.station import StationFile
    from storage import settings
    from tasks.stages.stoppable import stop_watch
    from tasks.station.check_devices import check_station
    from tasks.station.connected_station import StopRequested, StopSwitch

    station, switch = settings.read(Path(station_file), StationFile), StopSwitch()
    try:
        with stopping(switch), stop_watch(station, home(), switch):
            trials = check_station(station, move, switch)
    except StopRequested as stopped:
        raise BrokenOff(f"stopped by {stopped}") from stopped
    if as_json:
        print_json({"format": "mimu-station-check/1", "trials": list(map(_as_data, trials))})
    else:
        rows = [(t.device, t.tried, "works" if t.works else "FAILS", say(t.found)) for t in trials]
        print_rows(str(station_file), ("device", "tried", "", "found"), rows)
    if not all(trial.works for trial in trials):
        raise typer.Exit(1)


@app.command(epilog="Example: mimucal station load station.json r8b7e8cc74921")
def load(
    station_file: options.Station, result: options.Calibrated, as_json: options.Json = False
) -> None:
    """Load the coefficients of a result into the unit, using the commands in the station file.

    The unit must be the calibrated one and acknowledge each command.
    """
    from flows.terminal import print_json
    from schemas.orders import ExportOrder, order_of
    from schemas.station import StationFile
    from storage import settings
    from storage.stations import one_run_on
    from tasks.stages.correct import export_correction
    from tasks.station.load_coefficients import load_correction

    station = settings.read(Path(station_file), StationFile)
    order = order_of(ExportOrder, calibration=result, **{"as": "json"})
    correction, _ = export_correction(order, home())
    with one_run_on(station.station.id, home()):
        unit, lines = load_correction(correction, station)
    if as_json:
        loaded = {"unit": unit.model_dump(mode="json"), "lines": lines}
        print_json({"format": "mimu-station-load/1", **loaded})
        return
    print(f"{unit.manufacturer} {unit.model} {unit.serial} acknowledged {lines} lines")


@app.command(epilog="Example: mimucal station status")
def status(as_json: options.Json = False) -> None:
    """Show the state of the latest run on each station."""
    from flows.acquisition_view import facts
    from flows.terminal import print_json, print_rows
    from storage.stations import end_dead_statuses, statuses

    end_dead_statuses(home())
    found = statuses(home())
    if as_json:
        runs = [each.model_dump(mode="json") | {"is_dead": is_dead} for each, is_dead in found]
        print_json({"format": "mimu-station-status/1", "runs": runs})
        return
    rows = []
    for each, is_dead in found:
        shown = facts(each) | {"cause": each.cause}
        stands = "its process died: " * is_dead + "; ".join(filter(None, shown.values()))
        rows.append((each.station, each.procedure, f"{each.at:%F %T}", stands))
    print_rows("Stations", ("station", "procedure", "UTC", "how it stands"), rows)


@app.command(epilog="Example: mimucal station work LINE-1")
def work(station: options.OrderedStation) -> None:
    """Take the orders of a station one by one.

    Where PREFECT_API_URL names a server, as the one worker of the station's pool, for good. Without
    one, until none waits: `mimucal order` and the pages begin it where an order needs it.
    """
    from flows.on_prefect.server import server_named
    from flows.orders.production import submit, work_at

    if server_named():
        from flows.on_prefect.queue import work_at_station

        work_at_station(station, home(), submit)

    def report(order: "ProductionOrder") -> None:
        outcome = order.fault or ", ".join(order.certificates)
        print(f"{order.number} {order.serials}: {order.state} {outcome}", flush=True)

    if not work_at(station, home(), report):
        print(f"another process takes the orders of station {station} already")


@app.command(epilog="Example: mimucal station stop LAB-1")
def stop(
    station: options.StationOrFile, by: options.StoppedBy = None, as_json: options.Json = False
) -> None:
    """Stop a station's table now, whatever else runs or does not.

    Works without the database and Prefect, and without the home where MIMUCAL_STATION names a
    folder of this computer. The recording is kept; `acquire --resume` continues the run.
    Exits with 1 where it could not be confirmed that the table is at rest.
    """
    from tasks.stages.stop import current_user, stop_station

    stopped = stop_station(station, by or current_user(), home())
    if as_json:
        print(stopped.model_dump_json(indent=1))
    if not stopped.at_rest:
        raise BrokenOff(
            f"it could not be confirmed that the table of station {stopped.station} is at rest "
            f"({stopped.fault}): use the emergency stop"
        )
    if not as_json:
        axes = ", ".join(f"{axis.name} {axis.angle_deg:.4f}°" for axis in stopped.axes)
        print(f"station {stopped.station} is at rest after {stopped.seconds:.1f} s: {axes}")
        for recording in stopped.recordings:
            print(f"recorded so far: {recording} (`mimucal acquire --resume` continues)")
        print(f"its orders wait for `mimucal station release {stopped.station}`")


@app.command(epilog="Example: mimucal station release LAB-1 --by Li")
def release(station: options.OrderedStation, by: options.ReleasedBy = None) -> None:
    """Let the orders of a station go on after it was stopped; see first that it may turn.

    A run that is started by hand, with `mimucal acquire`, releases it, too.
    """
    from storage import stations
    from tasks.stages.stop import current_user

    stop = stations.lockout_of(station, home())
    if stop is None:
        print(f"station {station} is not locked out")
        return
    person = by or current_user()
    stations.release(station, person, home())
    at = f"{stop.at.astimezone():%F %T}"
    print(f"station {station} released by {person}; it was stopped by {stop.by} at {at}")


@app.command(epilog="Example: mimucal station page LAB-1 --port 8770")
def page(
    station: options.StationOrFile,
    port: options.PagesPort = 8770,
    by: options.StoppedBy = None,
) -> None:
    """Serve the page of the station's own computer: how it stands, and a button that stops it.

    Only this computer reaches it. It works with everything else down.
    """
    from flows.station_page import serve_page
    from tasks.stages.stop import current_user

    serve_page(station, port, by or current_user(), home())


def _as_data(trial: "Trial") -> dict[str, Any]:
    sentences = text_fields("found", trial.found, CONTRACTED)
    return {"device": trial.device, "tried": trial.tried, "works": trial.works} | sentences


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise Unusable(f"{path} cannot be written ({error.strerror}); name another file") from error
