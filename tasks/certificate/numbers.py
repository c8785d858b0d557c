"""The numbers of one item as texts: values, second values, and the uncertainties of either."""

from dataclasses import dataclass

from schemas.calibration import Calibration
from tasks.specifications.items import second_value
from tasks.words.rounding import USUAL_K, column

# Items whose numbers are written in one power of ten, so that they can be compared.
SAME_EXPONENT = {
    "gyro_cross_coupling": "accel_cross_coupling",
    "accel_cross_coupling": "gyro_cross_coupling",
}


@dataclass(frozen=True)
class Numbers:
    """Values and second values of an item with their U, in units of 10^exponent."""

    exponent: int
    values: tuple[str | None, ...]
    seconds: tuple[str | None, ...]
    U: tuple[str | None, ...]
    U_second: tuple[str | None, ...]

    @property
    def separate(self) -> bool:
        """Whether the second values have a U that is not that of the first."""
        return any(other != U for U, other in zip(self.U, self.U_second, strict=True) if other)


def numbers(calibration: Calibration, name: str, elements: tuple[str, ...], two: bool) -> Numbers:
    """The numbers of an item; cross couplings of both triads share the power of ten."""
    items = calibration.items
    item, paired = items.get(name), items.get(SAME_EXPONENT.get(name, ""))
    second = getattr(item, second_value(name) or "", None) if two else None
    U = item.U if item else {}
    own = item.U_without_earth_rotation if item and second else None
    sources = ((item.value if item else {}, U), (second or {}, own or U))
    pairs = [(value.get(e), u.get(e)) for value, u in sources for e in elements]
    others = [(value, paired.U.get(e)) for e, value in paired.value.items()] if paired else []
    every, n = [*pairs, *others], len(elements)
    printed = column(
        [value for value, _ in every], [u for _, u in every], item.k if item else USUAL_K
    )
    return Numbers(
        printed.exponent,
        printed.values[:n],
        printed.values[n : 2 * n],
        printed.uncertainties[:n],
        printed.uncertainties[n : 2 * n],
    )
