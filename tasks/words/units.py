"""Units as they are printed; the keys are those of the schemas."""

UNITS = {
    "deg/s": "°/s", "m/s2": "m/s²", "(deg/s)/g": "(°/s)/g", "deg": "°", "deg/h": "°/h",
    "deg/sqrt(h)": "°/√h", "(m/s2)/sqrt(Hz)": "(m/s²)/√Hz",
}  # fmt: skip


def unit_text(unit: str) -> str:
    """A unit as it is printed."""
    return UNITS.get(unit, unit)


def quantity_text(number: str, unit: str) -> str:
    """A number with its unit as it is printed; a ratio has none."""
    return number if unit == "1" else f"{number} {unit_text(unit)}"
