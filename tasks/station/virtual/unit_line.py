"""The lines of text on a unit's connection: the unit tells its serial number, and another unit is
mounted by those who send what an operator's hands would do.
"""

import asyncio

from tasks.station.virtual.protocol import (
    MOUNT_ANSWER,
    MOUNT_REQUEST,
    REFUSAL,
    SERIAL_ANSWER,
    SERIAL_REQUEST,
)
from tasks.station.virtual.simulation import Simulation

LONGEST = 64  # characters of a serial number


async def attend(
    simulation: Simulation,
    place: int,
    lines: asyncio.StreamReader,
    client: asyncio.StreamWriter,
) -> None:
    """Answers each line of a client of the unit at a place, until it hangs up."""
    try:
        while line := await lines.readline():
            answered = answer(simulation, place, line.decode("ascii", "replace").strip())
            if answered is not None:
                client.write(f"{answered}\r\n".encode("ascii", "replace"))
    except (OSError, ValueError):  # it is gone, or sends what is no line
        return


def answer(simulation: Simulation, place: int, line: str) -> str | None:
    """What a line is answered with; None for what is no request, and from a unit without supply."""
    if line.startswith(MOUNT_REQUEST):
        unit = line.removeprefix(MOUNT_REQUEST)
        serial, _, seed = unit.partition(",")
        if not (0 < len(serial) <= LONGEST and serial.isprintable() and seed.isdecimal()):
            return f"{REFUSAL}send {MOUNT_REQUEST}SERIAL,SEED"
        simulation.mount(place, serial, int(seed))
        return f"{MOUNT_ANSWER}{serial}"
    if line != SERIAL_REQUEST or not simulation.is_supplied:
        return None
    mounted = (simulation.config.unit, *simulation.config.neighbours)[place]
    return f"{SERIAL_ANSWER}{mounted.serial}"
