"""A laboratory whose equipment's certificates state what Table 1 of the specifications asks for."""

import math
from pathlib import Path

from schemas.laboratory import EquipmentLimit, LimitName

ARCSECOND = math.radians(1 / 3600)
HALF_WIDTHS: dict[LimitName, float] = {
    "rate": 1e-5, "ripple": 5e-4, "position": 10 * ARCSECOND, "repeatability": 5 * ARCSECOND,
    "axes": 10 * ARCSECOND, "fixture": 10 * ARCSECOND,
}  # fmt: skip
SOURCE = "certificate T-2026-1"


def as_table_1(**changes: float) -> dict[LimitName, EquipmentLimit]:
    """The limits, some with another half-width."""
    return {
        name: EquipmentLimit(
            half_width=changes.get(name, half_width), distribution="rectangular", source=SOURCE
        )
        for name, half_width in HALF_WIDTHS.items()
    }


def laboratory_file(folder: Path) -> Path:
    """The file of a laboratory with these limits."""
    lines = ['[party]', 'name = "Laboratory"', 'name_zh = "实验室"', 'address = "a"',
             'address_zh = "址"']  # fmt: skip
    lines = ['issuer_title = "Head"', *lines, "[[equipment]]", 'name = "Turntable"',
             'name_zh = "转台"', 'serial = "T-1"', 'accuracy = "as Table 1"',
             f'certificate = "{SOURCE}"']  # fmt: skip
    for name, limit in as_table_1().items():
        lines += [f"[limits.{name}]", f"half_width = {limit.half_width}",
                  'distribution = "rectangular"', f'source = "{SOURCE}"']  # fmt: skip
    path = folder / "laboratory.toml"
    folder.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path
