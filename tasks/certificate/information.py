"""What stands beside the clauses' results, as printed rows. Nothing is decided on it.

A pair is (Chinese, English). Numbers are texts by JJF 1059.1, in units of 10^exponent.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from schemas.calibration import Calibration, Elements, Information
from tasks.certificate.names import Pair
from tasks.certificate.typography import pair
from tasks.words.rounding import column, round_up, text
from tasks.words.units import quantity_text, unit_text

# Which value of an item contains what the separated one does not.
EARTH = "gyro_g_sensitivity_without_earth_rotation"
# Remarks by which the data do not tell that Earth's rotation is in them.
UNSEEN = {"earth_rotation_not_visible", "earth_rotation_not_shown", "earth_rotation_odd"}
CONTAINED = {
    EARTH: (
        ("式(7)的值", "The value by eq. (7)"), ("地球自转", "Earth's rotation"),
    ),
    "accel_rate_sensitivity_without_lever_arm": (
        ("式(12)、式(13)的值", "The value by eq. (12), (13)"), ("杆臂", "the lever arm"),
    ),
}  # fmt: skip
BY_NO_EQUATION = ("上述值", "The value")  # of the joint method


@dataclass(frozen=True)
class Cell:
    """One element: its name, value and U; None: no number."""

    element: str
    value: str | None
    U: str | None


@dataclass(frozen=True)
class InformationRow:
    """One quantity: title, unit, lines of up to three cells (None: no such element), sentences.

    lines: empty where no element has a value.
    """

    title: Pair
    unit: str
    exponent: int
    lines: tuple[tuple[Cell | None, ...], ...]
    said: Pair


def information_rows(calibration: Calibration) -> tuple[InformationRow, ...]:
    """Everything the result shows beside its items."""
    return tuple(map(_row, calibration.information.values()))


def contained(calibration: Calibration, item: str) -> tuple[Pair, ...]:
    """What the clause's value of an item contains, where that is more than its U; how much."""
    joint = calibration.method == "joint"
    unseen = UNSEEN & {remark.code for remark in calibration.remarks}
    return tuple(
        _contained(BY_NO_EQUATION if joint else CONTAINED[name][0], CONTAINED[name][1], *most)
        for name, each in calibration.information.items()
        if name in CONTAINED and each.about == item and not (name == EARTH and unseen)
        for most in _most(calibration, item, each)
    )


def _most(
    calibration: Calibration, item: str, separated: Information
) -> Iterator[tuple[str, float, float, str]]:
    """Element, difference, U and unit where the difference is largest against U, if above U."""
    clause = calibration.items[item]
    apart = {
        element: value - other
        for element, other in separated.value.items()
        if other is not None and (value := clause.value.get(element)) is not None
    }
    times = {e: abs(d) / U for e, d in apart.items() if (U := clause.U.get(e))}
    worst = max(times, key=lambda element: times[element], default=None)
    if worst is not None and times[worst] > 1.0:
        yield worst, apart[worst], times[worst], clause.unit


def _contained(
    value: Pair, what: Pair, element: str, difference: float, times: float, unit: str
) -> Pair:
    much = quantity_text(str(text(round_up(abs(difference)))), unit)
    often = f"{float(f'{times:.2g}'):g}"
    return pair(
        f"{value[0]}含{what[0]}：{element} 处最显著，为 {much}，即 U 的 {often} 倍；"
        "分离后的值见“附加信息”。",
        f"{value[1]} contains {what[1]}: most clearly at {element}, {much}, {often} times U; the "
        "value without it stands under For information.",
    )


def _row(shown: Information) -> InformationRow:
    U: Elements = shown.U or {}
    elements = tuple(shown.value)
    made = column([shown.value[e] for e in elements], [U.get(e) for e in elements], shown.k)
    cells = {e: Cell(e, made.values[i], made.uncertainties[i]) for i, e in enumerate(elements)}
    known = any(value is not None for value in made.values)
    return InformationRow(
        title=(shown.title_zh, shown.title),
        unit=unit_text(shown.unit),
        exponent=made.exponent,
        lines=tuple(_lines(cells)) if known else (),
        said=pair(shown.zh, shown.en),
    )


def _lines(cells: dict[str, Cell]) -> Iterator[tuple[Cell | None, ...]]:
    """Three cells a line; elements like xy stand where a matrix has them."""
    if all(len(e) == 2 and set(e) <= set("xyz") for e in cells):
        for reads in "xyz":
            line = tuple(cells.get(reads + given) for given in "xyz")
            if any(line):
                yield line
        return
    every: list[Cell | None] = list(cells.values())
    for start in range(0, len(every), 3):
        yield tuple([*every[start : start + 3], None, None][:3])
