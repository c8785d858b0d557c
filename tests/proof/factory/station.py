"""A virtual station of the factory: `python -m tests.proof.factory.station ID SEED SPEED PORT FILE
FAULT…`. The unit is on the next port.

Its table keeps ten encoder samples a second in place of a hundred: reading them is most of what a
run costs.
"""

import asyncio
import os
import sys
from pathlib import Path

from schemas.station import StationFile
from tasks.station.virtual.config import TableDesign, VirtualStation
from tasks.station.virtual.faults import StationFault
from tasks.station.virtual.servers import serve
from tasks.station.virtual.unit import draw_unit

CAPTURE_MS = 100


def main(
    id_: str, seed: int, speed: float, port: int, file: Path, faults: list[StationFault]
) -> None:
    config = VirtualStation(
        id=id_, table=TableDesign(capture_ms=CAPTURE_MS), unit=draw_unit(seed)
    )

    def ready(station: StationFile) -> None:
        draft = file.with_suffix(".new")
        draft.write_text(station.model_dump_json(indent=1), encoding="utf-8")
        os.replace(draft, file)

    asyncio.run(
        serve(config, modbus_port=port, unit_port=port + 1, speed=speed, faults=faults, ready=ready)
    )


if __name__ == "__main__":
    id_, seed, speed, port, file, *faults = sys.argv[1:]
    main(id_, int(seed), float(speed), int(port), Path(file), list(map(StationFault.parse, faults)))
