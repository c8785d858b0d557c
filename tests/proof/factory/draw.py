"""What a play is about, drawn from its seed: units, their faults, orders and clients."""

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

# Faults of FAULTS (tasks.station.virtual.faults), by what is to become of the order.
DISTURBED = ("unit_repeats", "unit_late", "modbus_cut", "settled_too_soon")  # the run copes
STOPPED = ("emergency_stop", "interlock", "unit_silent")  # cleared by hand, and it goes on
REJECTED = (
    "stuck_channel",
    "wrong_sign",
    "saturated_axis",
    "unit_garbage",
)  # the run is kept, and is no valid one
OUT = "out_of_tolerance"  # a gyro scale factor beyond its limit: the unit fails
FAULTY = 0.15  # of the units have one
BY_CHANCE = "invalid by chance"  # as where the station's computer was too busy: measured anew
STOPS_AFTER_S = (4.0, 16.0)  # wall time from the mounting to a fault that stops the run
CLIENTS = ("North Works", "Harbour Instruments", "Valley Avionics")
EVERY_MONTH = CLIENTS[0]  # its units come back in a month
FULL = 4  # units that are measured by jjf2003 as it is shipped

Procedure = Literal["jjf2003", "factory"]


@dataclass(frozen=True)
class OrderedUnit:
    """An order of the factory. fault: of the unit or its station, a name of FAULTS."""

    number: str
    serial: str
    seed: int
    station: str
    procedure: Procedure
    client: str
    fault: str | None

    @property
    def is_rejected(self) -> bool:
        """Whether the run is expected to be invalid, so that there is no certificate."""
        return self.fault in (*REJECTED, BY_CHANCE)

    @property
    def verdict(self) -> str | None:
        """On the unit, as the factory's own book has it; None where it depends on how the run went.

        The factory's own procedure is too short for a verdict.
        """
        if self.procedure == "factory" and not self.is_rejected:
            return "inconclusive"
        return {None: "pass", OUT: "fail"}.get(self.fault)


def ordered(seed: int, count: int, stations: Sequence[str]) -> tuple[OrderedUnit, ...]:
    """The orders in their sequence, one unit each."""
    rng = random.Random(seed)
    faults = DISTURBED + STOPPED + REJECTED
    made = []
    for number in range(count):
        fault = rng.choice(faults) if rng.random() < FAULTY else None
        fault = OUT if number == 1 else fault
        made.append(
            OrderedUnit(
                number=f"F{seed}-{number + 1:04d}", serial=f"V{seed:02d}{number + 1:04d}",
                seed=rng.randrange(2**31), station=stations[number % len(stations)],
                procedure="jjf2003" if number < FULL else "factory",
                client=rng.choice(CLIENTS), fault=fault,
            )
        )  # fmt: skip
    return tuple(made)
