"""Units as they are printed; the keys are those of the schemas."""

SPELLINGS = (
    ("m/s2", "m/s²"), ("(rad/s)2", "(rad/s)²"), ("^2", "²"), ("^3", "³"), ("deg", "°"), ("*", "·"),
    ("sqrt(h)", "√h"), ("sqrt(Hz)", "√Hz"),
)  # fmt: skip


def unit_text(unit: str) -> str:
    """A unit as it is printed."""
    for ascii_, printed in SPELLINGS:
        unit = unit.replace(ascii_, printed)
    return unit


def quantity_text(number: str, unit: str) -> str:
    """A number with its unit as it is printed; a ratio has none."""
    if unit == "deg":
        return f"{number}°"
    return number if unit == "1" else f"{number} {unit_text(unit)}"
