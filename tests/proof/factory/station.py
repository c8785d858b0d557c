"""A virtual station of the factory.

`python -m tests.proof.factory.station ID SERIAL SEED SPEED PORT FILE FAULT…`; the unit is on the
next port. Its table keeps ten encoder samples a second in place of a hundred: reading them is most
of what a run costs.
"""

import asyncio
import os
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np

from schemas.station import StationFile
from tasks.station.virtual.config import TableDesign, VirtualStation, draw_unit
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.servers import serve
from tests.proof.factory.draw import OUT

CAPTURE_MS = 100
TOO_LARGE = 1.05  # the limits are ±1.5 %
PRIORITY = -10  # a table has a computer of its own; here it shares the cores with everything else


def main(config: VirtualStation, speed: float, port: int, file: Path, faults: list[str]) -> None:

    with suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, PRIORITY)

    def ready(station: StationFile) -> None:
        draft = file.with_suffix(".new")
        draft.write_text(station.model_dump_json(indent=1), encoding="utf-8")
        os.replace(draft, file)

    asyncio.run(
        serve(
            config,
            modbus_port=port,
            unit_port=port + 1,
            speed=speed,
            faults=map(StationFault.parse, faults),
            ready=ready,
        )
    )


if __name__ == "__main__":
    id_, serial, seed, speed, port, file, *faults = sys.argv[1:]
    unit = draw_unit(int(seed)).model_copy(update={"label": serial})
    if OUT in faults:
        faults.remove(OUT)
        scale = (np.array(unit.gyro.scale) @ np.diag([TOO_LARGE, 1.0, 1.0])).tolist()
        unit = unit.model_copy(update={"gyro": unit.gyro.model_copy(update={"scale": scale})})
    table = TableDesign(capture_ms=CAPTURE_MS)
    main(
        VirtualStation(id=id_, table=table, unit=unit), float(speed), int(port), Path(file), faults
    )
