"""Rates and forces in another unit than rad/s and m/s²."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from schemas.recording import ACCEL, AXES, GYRO, Recording, Segment
from schemas.text import Remark
from tasks.motion.whole import STANDARD_GRAVITY, gravity_of
from tasks.readings.implausible import found_on_sight, ratio_text
from tasks.readings.segment_means import DEG, FEW, NEAR, SegmentMeans, common_factor
from tasks.readings.wrong_time import AS_FAR, turned_ratio
from tasks.words import Message, message

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
FINE = ("mg", "mdps", "deg/h")  # units so small that whole numbers of them are written
WHOLE = 1e-6  # by which numbers that are whole may be off, for they were kept in SI
MOST = 0.9  # of the rests that agree on the size of gravity
ALIKE = 0.03  # of a factor, by which the axes of one setting may differ
ROWS = slice(0, 20_000)  # that show how numbers were written
STEPS = (16384.0, 8192.0, 4096.0, 2048.0)  # counts per g of usual accelerometers


def wrong_forces(recording: Recording, means: SegmentMeans, scale: float) -> Remark | None:
    """What the accelerometers read at rest that is not gravity in m/s²."""
    own = means.accel[means.static]
    own = own[np.isfinite(own).all(axis=1)]
    sizes = np.linalg.norm(own, axis=1)
    gravity = gravity_of(recording)
    if len(sizes) < FEW or not sizes.any():
        return None
    size = float(np.median(sizes))
    off = np.abs(np.log(np.maximum(sizes, 1e-12) / size))
    shown = {"read": f"{size:.4g}" if size >= 1 else f"{size:.2g}", "gravity": f"{gravity:.4f}",
             "ratio": f"{size / gravity:.4g}"}  # fmt: skip
    if FORCES[0] < size / gravity < FORCES[1]:
        axes = len(np.unique(np.abs(own).argmax(axis=1)))
        if abs(np.log(size / gravity)) < NEAR or off.max() > ALIKE or axes < 2:
            return None
        return found_on_sight(
            "force_setting", message("plausibility-force-setting", **shown), run="remarks"
        )
    if size < REMOVED * gravity:
        return found_on_sight(
            "gravity_removed", message("plausibility-gravity-removed", read=shown["read"])
        )
    factor = scale * gravity / size  # m/s² that one as it was written is
    usual = [(1.0, "m/s2"), (STANDARD_GRAVITY, "g"), (1e-3 * STANDARD_GRAVITY, "mg"),
             (0.3048, "ft/s2"),
             *((STANDARD_GRAVITY / n, f"{n:.0f}/g") for n in STEPS)]  # fmt: skip
    unit = None
    if np.quantile(off, MOST) < NEAR:
        unit = _unit(factor, usual, recording.imu.stack(ACCEL, ROWS) / scale)
    return found_on_sight("force_unit", _unit_sentence("force", "accel", unit, shown))


def _unit_sentence(
    what: str, triad: str, unit: tuple[str, float] | None, shown: Mapping[str, str]
) -> Message:
    """What was read, and the unit that it looks like; or no advice where it looks like none."""
    name, off = unit or ("-", 0.0)
    option = f"--units {triad}={name}" if unit else ""
    return message(f"plausibility-{what}-unit", **shown, unit=name, off=f"{100.0 * off:.1f}",
                   advised="yes" if unit else "no", option=option)  # fmt: skip


def _unit(
    factor: float, usual: Sequence[tuple[float, str]], written: np.ndarray
) -> tuple[str, float] | None:
    """The usual unit of a factor to SI and how far (relative) the factor is from it, where the
    numbers (n, 3) as they were written are such as that unit's: counts are whole, and units as
    large as g are not. Else None.
    """
    size, name = min(usual, key=lambda one: abs(np.log(factor / one[0])))
    off = abs(factor / size - 1.0)
    numbers = written[np.isfinite(written)]
    is_whole = bool(np.abs(numbers - np.rint(numbers)).max(initial=0.0) < WHOLE)
    of_counts = name.partition("/")[0].replace(".", "").isdecimal()
    is_such = is_whole if of_counts else name in FINE or not is_whole
    return (name, float(off)) if abs(np.log(factor / size)) < NEAR and is_such else None


def wrong_table(
    recording: Recording, means: SegmentMeans, between_rests: Callable[[], list[float]]
) -> Remark | None:
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
    return found_on_sight("table_unit", sentence) if is_right else None


def wrong_labels(segments: Sequence[Segment], means: SegmentMeans) -> Remark | None:
    """Labels of rates that gyros read as if they, or the gyros, were in the other of rad and °."""
    stated = {
        k: abs(means.gyro[k, AXES.index(s.axis)]) / (DEG * abs(s.rate_deg_s))
        for k, s in enumerate(segments)
        if s.kind == "rate" and s.axis and s.rate_deg_s and np.isfinite(means.gyro[k]).all()
    }
    for factor in (DEG, 1.0 / DEG):
        off = [k for k, ratio in stated.items() if abs(ratio / factor - 1.0) < NEAR]
        if len(off) > 0.5 * len(stated):
            names, label = tuple(segments[k].name for k in off), segments[off[0]].rate_deg_s or 0.0
            sentence = message(
                "plausibility-label-unit", count=len(off), segment=names[0], label=f"{label:g}",
                read=f"{abs(label) * stated[off[0]]:.4g}",
            )  # fmt: skip
            return found_on_sight("label_unit", sentence, names)
    return None


def wrong_rates(
    recording: Recording, sizes: np.ndarray, by_rate: np.ndarray, scale: float, source: str
) -> Remark | None:
    """A factor of the gyros' that no scale factor is.

    sizes: (r,) of their responses to the inputs; by_rate: (k,) to each rate alone: of a range that
    is too small they differ. source: of the rates that these are: labels, table or pose.
    """
    common = common_factor(sizes)
    if common is None or abs(np.log(common)) < NEAR:
        return None
    if GAINS[0] < common < GAINS[1]:
        every = np.concatenate([sizes, by_rate])
        if len(sizes) < 2 or np.abs(np.log(np.maximum(every, 1e-9) / common)).max() > ALIKE:
            return None
        sentence = message("plausibility-rate-setting", ratio=f"{common:.3f}", source=source)
        return found_on_sight("rate_setting", sentence, run="remarks")
    unit = _unit(scale / common, RATES, recording.imu.stack(GYRO, ROWS) / scale)
    shown = {"ratio": ratio_text(common), "source": source}
    return found_on_sight("rate_unit", _unit_sentence("rate", "gyro", unit, shown))


def wrong_rates_by_ways(
    recording: Recording, ratios: Sequence[float], scale: float
) -> Remark | None:
    """A usual wrong unit of gyros that nothing but gravity says anything of."""
    ratio = min(ratios, default=0.0)
    direct = [one for one in ratios if one < DIRECT * ratio]
    if ratio < LEAST_WAYS or len(direct) <= FEW:
        return None
    unit = _unit(scale / ratio, RATES, recording.imu.stack(GYRO, ROWS) / scale)
    shown = {"ratio": ratio_text(ratio), "source": "gravity"}
    return unit and found_on_sight("rate_unit", _unit_sentence("rate", "gyro", unit, shown))
