"""The `station` commands: serve the virtual station, check a station, load coefficients."""

import asyncio
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from flows import deploy_commands, options
from schemas.base import Unusable

if TYPE_CHECKING:
    from schemas.station import StationFile
    from tasks.station.check_devices import Trial

app = typer.Typer(
    help="Serve a virtual station, check and watch stations, load units.", rich_markup_mode=None
)

app.command(epilog="Example: mimucal station add station.json --schedule '0 8 * * 1-5'")(
    deploy_commands.add
)
app.command(epilog="Example: mimucal station remove VIRTUAL-1")(deploy_commands.remove)


@app.command(epilog="Example: mimucal station serve --speed 60")
def serve(
    host: options.Host = "127.0.0.1",
    port: options.Port = 5020,
    speed: options.Speed = 1.0,
    fault: options.Faults = None,
    seed: options.Seed = 1,
    ahrs: options.Ahrs = False,
    station_file: options.StationFile = Path("station.json"),
    truth: options.Truth = None,
) -> None:
    """Serve a virtual station until stopped."""
    from tasks.station.virtual import config as virtual
    from tasks.station.virtual.faults import StationFault
    from tasks.station.virtual.servers import serve

    station = virtual.virtual_station(seed, ahrs)
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
    from flows.printing import print_json, print_rows
    from schemas.station import StationFile
    from storage import settings
    from storage.home import home
    from storage.station_lock import one_run_on
    from tasks.station.check_devices import check_station

    station = settings.read(Path(station_file), StationFile)
    with one_run_on(station.station.id, home()):
        trials = check_station(station, move)
    if as_json:
        print_json({"format": "mimu-station-check/1", "trials": list(map(_as_data, trials))})
    else:
        rows = [(t.device, t.tried, "works" if t.works else "FAILS", t.found.en) for t in trials]
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
    from flows.printing import print_json
    from schemas.orders import ExportOrder, order_of
    from schemas.station import StationFile
    from storage import settings
    from storage.home import home
    from storage.station_lock import one_run_on
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
    from flows.printing import print_json, print_rows
    from storage.home import home
    from storage.station_lock import statuses

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


def _as_data(trial: "Trial") -> dict[str, Any]:
    sentences = {"found": trial.found.en, "found_zh": trial.found.zh}
    return {"device": trial.device, "tried": trial.tried, "works": trial.works} | sentences


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise Unusable(f"{path} cannot be written ({error.strerror}); name another file") from error
