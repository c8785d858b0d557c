"""Rates and forces in another unit than rad/s and m/s²."""

from collections.abc import Callable, Sequence

import numpy as np

from schemas.recording import Recording
from tasks.motion.whole import STANDARD_GRAVITY, gravity_of
from tasks.readings.axes import TriadMatrix
from tasks.readings.implausible import Implausible, ratio_text
from tasks.readings.segment_means import DEG, FEW, NEAR, SegmentMeans, common_factor
from tasks.readings.wrong_time import AS_FAR, turned_ratio
from tasks.words import message

GAINS = (0.2, 5.0)  # of a gyro: what is nearer is a range or a scale factor
FORCES = (0.5, 1.5)  # of gravity at rest: what is nearer is a scale factor or a bias
REMOVED = 0.07  # of gravity at rest: biases alone
LEAST_WAYS = 20.0  # times the angle between rests that no unit is turned from one to the other
RIGHT_WAY = 0.5  # times that angle: gyros that read less than it do not read rad/s
DIRECT = 4.0  # times the most direct way: a way as people turn units
RATES = (
    (1.0, "rad/s"), (DEG, "deg/s"), (1e-3 * DEG, "mdps"), (1e-3, "mrad/s"), (DEG / 3600.0, "deg/h"),
    (DEG / 131.0, "131/dps"), (DEG / 65.5, "65.5/dps"), (DEG / 32.8, "32.8/dps"),
    (DEG / 16.4, "16.4/dps"), (1.0 / DEG, "57.2958rad/s"), (16.4, "16.4rad/s"),
    (32.8, "32.8rad/s"), (65.5, "65.5rad/s"), (131.0, "131rad/s"),
)  # fmt: skip
STEPS = (16384.0, 8192.0, 4096.0, 2048.0)  # counts per g of usual accelerometers


def wrong_forces(recording: Recording, means: SegmentMeans, scale: float) -> Implausible | None:
    """What the accelerometers read at rest that is not gravity in m/s²."""
    own = means.accel[means.static]
    sizes = np.linalg.norm(own[np.isfinite(own).all(axis=1)], axis=1)
    gravity = gravity_of(recording)
    if len(sizes) < FEW or not sizes.any():
        return None
    size = float(np.median(sizes))
    if FORCES[0] < size / gravity < FORCES[1]:
        return None
    read = f"{size:.4g}" if size >= 1 else f"{size:.2g}"
    if size < REMOVED * gravity:
        return Implausible("gravity_removed", message("plausibility-gravity-removed", read=read))
    factor = scale * gravity / size  # m/s² that one as it was written is
    usual = [(1.0, "m/s2"), (STANDARD_GRAVITY, "g"), (1e-3 * STANDARD_GRAVITY, "mg"),
             (0.3048, "ft/s2"),
             *((STANDARD_GRAVITY / n, f"{n:.0f}/g") for n in STEPS)]  # fmt: skip
    unit = _unit(factor, usual, "m/s2", NEAR)
    return Implausible(
        "force_unit",
        message("plausibility-force-unit", read=read, gravity=f"{gravity:.4f}",
                ratio=f"{size / gravity:.4g}", unit=unit, option=f"--units accel={unit}"),
        f"--units accel={unit}",
    )  # fmt: skip


def _unit(factor: float, usual: Sequence[tuple[float, str]], si: str, near: float) -> str:
    """The usual unit of a factor to SI, else the factor itself."""
    size, name = min(usual, key=lambda one: abs(np.log(factor / one[0])))
    return name if abs(np.log(factor / size)) < near else f"{factor:.5g}{si}"


def wrong_table(
    recording: Recording, means: SegmentMeans, between_rests: Callable[[], list[float]]
) -> Implausible | None:
    """Encoders in degrees: they turn so much farther than gyros which labels, or else gravity, show
    to be right.

    between_rests: how far gyros turn over the angles that gravity turns by.
    """
    ratio = turned_ratio(recording)
    if ratio is None or not 1.0 / AS_FAR < ratio / DEG < AS_FAR:
        return None
    labelled = [abs(s.rate_deg_s) for s in recording.manifest.segments or () if s.rate_deg_s]
    if labelled:
        fastest = np.nanmax(np.linalg.norm(means.gyro, axis=1)) / (DEG * max(labelled))
        is_right = GAINS[0] < fastest < GAINS[1]
    else:
        way = between_rests()
        is_right = len(way) > FEW and RIGHT_WAY < min(way) < LEAST_WAYS
    option = "--units table=deg"
    sentence = message("plausibility-table-unit", ratio=ratio_text(1.0 / ratio), option=option)
    return Implausible("table_unit", sentence, option) if is_right else None


def wrong_rates(recording: Recording, gyro: TriadMatrix | None, scale: float) -> Implausible | None:
    """A factor of the gyros' that no scale factor is."""
    common = None if gyro is None else common_factor(gyro)
    if common is None or GAINS[0] < common < GAINS[1]:
        return None
    unit = _unit(scale / common, RATES, "rad/s", NEAR)
    option, source = f"--units gyro={unit}", "labels" if recording.table is None else "table"
    return Implausible(
        "rate_unit",
        message("plausibility-rate-unit", ratio=ratio_text(common), source=source, unit=unit,
                option=option),
        option,
    )  # fmt: skip


def wrong_rates_by_ways(ratios: Sequence[float], scale: float) -> Implausible | None:
    """A usual wrong unit of gyros that nothing but gravity says anything of."""
    ratio = min(ratios, default=0.0)
    direct = [one for one in ratios if one < DIRECT * ratio]
    if ratio < LEAST_WAYS or len(direct) <= FEW:
        return None
    unit = _unit(scale / ratio, RATES, "", NEAR)
    if not any(unit == name for _, name in RATES):
        return None
    option = f"--units gyro={unit}"
    shown = ratio_text(ratio)
    return Implausible(
        "rate_unit",
        message("plausibility-rate-unit", ratio=shown, source="gravity", unit=unit, option=option),
        option,
    )
