"""The virtual station as a server, until it is stopped."""

import asyncio
import json
from pathlib import Path

from schemas.base import Unusable
from schemas.station import StationFile
from tasks.station.virtual import config as virtual
from tasks.station.virtual.faults import Fault
from tasks.station.virtual.servers import serve


def virtual_station(ahrs: bool, seed: int) -> virtual.VirtualStation:
    """One axis with an AHRS, or three axes with a MIMU; the seed draws the unit."""
    return virtual.ahrs_station(seed) if ahrs else virtual.mimu_station(seed)


def serve_station(
    station: virtual.VirtualStation,
    host: str,
    port: int,
    speed: float,
    faults: tuple[str, ...],
    station_file: Path,
    truth: Path | None,
) -> None:
    """Serve a virtual station; its station file and its truth are written first.

    Raises Unusable for an unknown fault, a port that is taken, a file that cannot be written.
    """
    injected = tuple(Fault.parse(fault) for fault in faults)
    if truth is not None:
        _write(truth, json.dumps(virtual.truth(station), indent=1))

    def ready(file: StationFile) -> None:
        _write(station_file, file.model_dump_json(indent=1))
        print(f"Modbus/TCP {file.modbus_host}:{file.modbus_port}, unit {file.unit_link.url}")
        print(f"station file {station_file}; Ctrl-C stops the station", flush=True)

    try:
        asyncio.run(
            serve(
                station,
                host=host,
                modbus_port=port,
                unit_port=port + 1 if port else 0,
                speed=speed,
                faults=injected,
                ready=ready,
            )
        )
    except KeyboardInterrupt:
        print("station stopped")


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise Unusable(f"{path} cannot be written ({error.strerror}); name another file") from error
