"""Device 3 over the virtual fixture and the unit's supply: words out, orders in."""

from schemas.station import FIXTURE_REGISTERS
from tasks.station.virtual.config import STEP_US
from tasks.station.virtual.reality import Reality
from tasks.station.virtual.registers import BadValue, Place, Value, orders, to_words

FIXTURE_WORDS = FIXTURE_REGISTERS[-1].address + FIXTURE_REGISTERS[-1].words
PLACES: tuple[Place, ...] = tuple((each.address, each, None) for each in FIXTURE_REGISTERS)
ATTITUDE = ("qw", "qx", "qy", "qz")
SHORTEST = 0.1  # a quaternion below it says nothing


class FixtureRegisters:
    """What device 3 reads and takes."""

    def __init__(self, reality: Reality) -> None:
        self._reality = reality

    def words(self) -> list[int]:
        """All words of the device as they are now."""
        reality = self._reality
        values: dict[str, Value] = dict(zip(ATTITUDE, reality.fixture.wanted, strict=True))
        values |= {
            "turn": 0,
            "status": reality.fixture.status(reality.table.now),
            "supply": int(reality.is_supplied),
            "supply_on_time": reality.supplied_steps * STEP_US,
        }
        return [word for register in FIXTURE_REGISTERS
                for word in to_words(register, values[register.name])]  # fmt: skip

    def write(self, address: int, words: list[int]) -> None:
        """Takes words from an address on; raises BadAddress or BadValue as the table does."""
        taken = [(register.name, value) for register, _, value in orders(PLACES, address, words)]
        for name, value in taken:
            if not (abs(value) <= 1.0 if name in ATTITUDE else value in (0, 1)):
                raise BadValue
        for name, value in taken:
            self._take(name, value)

    def _take(self, name: str, value: Value) -> None:
        reality = self._reality
        if name in ATTITUDE:
            reality.fixture.wanted[ATTITUDE.index(name)] = value
        elif name == "supply":
            reality.supply(bool(value))
        elif value:
            if (reality.fixture.wanted**2).sum() < SHORTEST:
                raise BadValue
            reality.turn_fixture()
