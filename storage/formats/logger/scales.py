"""The unit of each channel: given, in the header, or by what leaves no doubt."""

from collections.abc import Mapping

import numpy as np

from schemas.recording import AXES, GYRO, Segment
from storage.formats.convert import STANDARD_GRAVITY
from storage.formats.logger.columns import Column
from storage.formats.logger.units import DEG, EXAMPLES, QUANTITIES, Scale, scale

OF_FORCE = (  # usual sizes of gravity in a unit, and the unit
    (1.0, "g"), (STANDARD_GRAVITY, "m/s2"), (1000.0, "mg"), (16384.0, "16384/g"),
    (8192.0, "8192/g"), (4096.0, "4096/g"), (2048.0, "2048/g"),
)  # fmt: skip
OF_RATE = ("deg/s", "rad/s", "mdps", "131/dps", "65.5/dps", "32.8/dps", "16.4/dps")
NEAR = 0.12  # of a usual size


def scale_of(
    name: str, own: Mapping[str, Column], given: Mapping[str, str], gravity: float,
    raw: Mapping[str, np.ndarray], t: np.ndarray, labels: tuple[Segment, ...],
) -> tuple[Scale | None, str]:  # fmt: skip
    """The unit of a triad and how it is known; or None and what to ask."""
    quantity = QUANTITIES[name]
    written = next(iter(own.values())).unit
    for text, how in ((given.get(name), "--units"), (written, "header")):
        if text and (one := scale(quantity, text, gravity)) is not None:
            return one, how
        if text and how == "--units":
            return None, f"--units {name}={text}: no such unit; it may be {EXAMPLES[quantity]}"
    if name == "temperature":
        return Scale("degC", 1.0), "taken for °C"
    values = np.array(list(raw.values()))
    if name == "accel":
        size = float(np.nanmedian(np.linalg.norm(values, axis=0)))
        for usual, text in OF_FORCE:
            if abs(size / usual - 1.0) < NEAR:
                return scale(quantity, text, gravity), f"gravity reads {size:.5g}"
    if name == "gyro" and (text := _unit_by_rates(raw, t, labels)):
        return scale(quantity, text, gravity), "by the rates of the protocol"
    stated = f" (its header says {written!r})" if written else ""
    return None, (
        f"{name}: in which unit are {', '.join(c.name for c in own.values())}?{stated} Give "
        f"--units {name}=…: {EXAMPLES[quantity]}"
    )


def _unit_by_rates(
    raw: Mapping[str, np.ndarray], t: np.ndarray, labels: tuple[Segment, ...]
) -> str | None:
    """The usual unit in which the gyros read the rates that the protocol says."""
    ratios = []
    for label in labels:
        rows = slice(*np.searchsorted(t, (label.t_start, label.t_end)))
        if label.kind != "rate" or not label.rate_deg_s or rows.stop - rows.start < 3:
            continue
        if all(channel in raw for channel in GYRO):
            means = [abs(float(np.nanmedian(raw[f"gyro_{axis}"][rows]))) for axis in AXES]
            ratios.append(abs(label.rate_deg_s) / max(*means, 1e-12))
    if not ratios:
        return None
    usual = float(np.median(ratios)) * DEG
    fits = [(abs(np.log(usual / one.factor)), text) for text in OF_RATE
            if (one := scale("rate", text, 1.0)) is not None]  # fmt: skip
    nearest = min(fits)
    return nearest[1] if nearest[0] < NEAR else None
