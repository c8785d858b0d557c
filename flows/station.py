"""The command `station serve`: the virtual station as a server, until it is stopped."""

import asyncio
import json
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from flows import options
from schemas.base import Unusable

if TYPE_CHECKING:
    from schemas.station import StationFile

app = typer.Typer(help="The virtual station.", rich_markup_mode=None)


@app.command()
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
    """A virtual station as a server, until it is stopped."""
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


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise Unusable(f"{path} cannot be written ({error.strerror}); name another file") from error
