"""The items that the specifications calibrate: symbol, unit and elements of each.

The names of items and elements stand in the catalogues under `item-…`, by the item's key.
"""

from dataclasses import dataclass
from typing import Literal

from schemas.recording import AXES
from schemas.text import Statement
from tasks.words import Message, message

# Elements: the axis that reads, then the input axis.
MATRIX_ELEMENTS = tuple(reads + given for reads in AXES for given in AXES)
OFF_DIAGONAL_ELEMENTS = tuple(e for e in MATRIX_ELEMENTS if e[0] != e[1])
# Column by column, as Appendix B of JJF 2003-2022 and Appendix C of JJF 1536-2015 list them.
BY_INPUT_AXIS = ("yx", "zx", "xy", "zy", "xz", "yz")

RATE_ERRORS = ("ε1", "ε2", "ε3", "ε4", "ε5")  # relative errors of the rate and of the time base
ANGLE_ERRORS = ("α1θ", "α2θ")  # of a turned angle

SecondValue = Literal["value_without_earth_rotation", "value_model"]


@dataclass(frozen=True)
class ItemDefinition:
    """The definition of an item, independent of any recording.

    letter, subscript: the symbol of an element; {e} is replaced by the element, {twice} by it
    twice. elements: in printing order; unit: as in results. second_value: the field of a result's
    item for the value beside that of the clause. divisor, power: the symbols of the equipment's
    errors by which the value is divided (`tasks.uncertainty.equipment`), and to which power.
    """

    key: str
    letter: str
    subscript: str
    unit: str
    elements: tuple[str, ...]
    second_value: SecondValue | None = None
    divisor: tuple[str, ...] = ()
    power: int = 1

    @property
    def title(self) -> Message:
        """The name of the item."""
        return message(f"item-{self.key.replace('_', '-')}")

    def element_title(self, element: str) -> Message:
        """The name of one element."""
        reads, given = element[0].upper(), element[-1].upper()
        return message(f"item-{self.key.replace('_', '-')}.element", reads=reads, input=given)

    def element_subscript(self, element: str) -> str:
        """What stands under the letter: gxx for a diagonal coefficient given as x."""
        return self.subscript.format(e=element, twice=element * 2)

    def symbol(self, element: str) -> str:
        """The symbol of an element as plain text, like K_gxx."""
        return f"{self.letter}_{self.element_subscript(element)}"


MIMU_ITEMS = (
    ItemDefinition("gyro_scale_factor", "K", "g{twice}", "1", AXES, divisor=RATE_ERRORS),
    ItemDefinition("gyro_cross_coupling", "K", "g{e}", "1", BY_INPUT_AXIS, divisor=RATE_ERRORS),
    ItemDefinition("gyro_fit_offset", "b", "{e}", "deg/s", AXES),
    ItemDefinition("gyro_bias", "B", "g{e}", "deg/s", AXES),
    ItemDefinition(
        "gyro_g_sensitivity", "g", "{e}", "(deg/s)/g", MATRIX_ELEMENTS,
        second_value="value_without_earth_rotation",
    ),
    ItemDefinition("accel_scale_factor", "K", "a{twice}", "1", AXES, divisor=("g",)),
    ItemDefinition("accel_cross_coupling", "K", "a{e}", "1", BY_INPUT_AXIS, divisor=("g",)),
    ItemDefinition("accel_bias", "B", "a{e}", "m/s2", AXES),
    ItemDefinition(
        "accel_rate_sensitivity", "p", "{e}", "m", OFF_DIAGONAL_ELEMENTS,
        second_value="value_model", divisor=RATE_ERRORS, power=2,
    ),
)  # fmt: skip
AHRS_ITEMS = (
    ItemDefinition("ahrs_scale_factor", "K", "{e}", "1", AXES, divisor=RATE_ERRORS),
    ItemDefinition("ahrs_zero_offset", "B", "{e}", "deg/s", AXES),
    ItemDefinition("ahrs_misalignment", "L", "{e}", "deg", BY_INPUT_AXIS, divisor=ANGLE_ERRORS),
)
ITEMS = {item.key: item for item in (*MIMU_ITEMS, *AHRS_ITEMS)}


def second_value(key: str) -> SecondValue | None:
    """The field of the value beside the clause's own; None where an item has one value."""
    return ITEMS[key].second_value if key in ITEMS else None


def item_title(key: str) -> Message | Statement:
    """The name of an item; its key where no specification has it."""
    return ITEMS[key].title if key in ITEMS else Statement(en=key, zh=key)


def symbol(key: str, element: str) -> str:
    """The symbol of an element as plain text, like K_gxx; the element where there is none."""
    return ITEMS[key].symbol(element) if key in ITEMS else element
