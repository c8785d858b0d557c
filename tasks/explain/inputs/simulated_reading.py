"""The assumed motion as the reference would report it: read once more with its noise and rounding.

What a fit makes of the errors of its reference, a simulated reading tells: the motion that was
found, read by the same encoders or cameras and smoothed again, beside itself (parametric bootstrap;
Efron and Tibshirani, An Introduction to the Bootstrap, 1993, ch. 6).
"""

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.spatial.transform import Rotation

from schemas.recording import Recording, Stream
from tasks.explain.inputs.blocks import FullRate
from tasks.explain.inputs.reference import smoothed_motion
from tasks.motion.pose import PLACE, POSE, Tracking
from tasks.motion.reference_noise import EncoderNoise
from tasks.motion.table import TableAxes
from tasks.motion.whole import Motion, whole_motion

SHIFT = 0.01  # of the angles: rests that far away lie anywhere between two codes
STILL = 0.003  # rad/s


def simulated_reading(
    recording: Recording, full: FullRate, rng: np.random.Generator
) -> tuple[Motion, Motion] | None:
    """The assumed motion at the unit's rows, and that motion as the reference would report it.

    Encoders are at other angles, so that rests are not where they round to: the assumed motion is
    one that they smoothed. None for a reference without errors.
    """
    if full.motion.tracking is not None and recording.reference is not None:
        pose = _with_noise(recording.reference, full.motion.tracking, rng)
        return full.motion, _read(replace(recording, reference=pose), full)
    encoders, table, axes = full.reference_noise.encoders, recording.table, full.motion.axes
    if encoders is None or table is None or axes is None or not encoders.variance.any():
        return None
    exact, noisy = _encoders_on(recording, full, table, encoders, axes, rng)
    return _read(replace(recording, table=exact), full), _read(
        replace(recording, table=noisy), full
    )


def _read(recording: Recording, full: FullRate) -> Motion:
    at, tracking = full.motion.t + full.start, full.motion.tracking
    motion = whole_motion(recording, at)
    if tracking is not None and tracking.place is not None and recording.reference is not None:
        motion = smoothed_motion(motion, recording.reference, at, tracking)
    return replace(
        motion, t=full.motion.t, recorded=full.motion.recorded, tracking=full.motion.tracking
    )


def _with_noise(pose: Stream, tracking: Tracking, rng: np.random.Generator) -> Stream:
    """Poses with as much noise again in each frame."""
    columns = dict(pose.columns)
    turns = np.sqrt(tracking.attitude_variance) * rng.standard_normal((len(pose.t), 3))
    turned = Rotation.from_quat(pose.stack(POSE), scalar_first=True) * Rotation.from_rotvec(turns)
    columns.update(zip(POSE, turned.as_quat(scalar_first=True).T, strict=True))
    for name in PLACE:
        if name in columns:
            moved = np.sqrt(tracking.place_variance) * rng.standard_normal(len(pose.t))
            columns[name] = columns[name] + moved
    return Stream(pose.t, columns)


def _encoders_on(
    recording: Recording, full: FullRate, table: Stream, encoders: EncoderNoise, axes: TableAxes,
    rng: np.random.Generator,
) -> tuple[Stream, Stream]:  # fmt: skip
    """Readings of encoders without and with noise on the assumed motion.

    Rests are off by their rounding and assumed to lie where they were read: so the motion is made
    slightly larger or smaller, and rounded again.
    """
    t = table.t - full.start
    thinned = max(1.0, encoders.rate.interval / float(np.median(np.diff(t))))
    exact, noisy = dict(table.columns), dict(table.columns)
    rates = np.nan_to_num(axes.speeds)
    steps = 0.5 * (rates[1:] + rates[:-1]) * np.diff(full.motion.t)[:, None]
    angles = np.nan_to_num(axes.angles[0]) + np.concatenate([0.0 * rates[:1], steps.cumsum(axis=0)])
    for k, axis in enumerate(recording.manifest.station.table_axes or ()):
        turned = CubicHermiteSpline(full.motion.t, angles[:, k], rates[:, k])(t)
        step, variance = encoders.steps[k], np.interp(t, encoders.t, encoders.variance[:, k])
        larger = 1.0 + SHIFT * rng.uniform(-1.0, 1.0) if step else 1.0
        turned = larger * turned + step * rng.uniform()
        rest = np.abs(np.interp(t, full.motion.t, rates[:, k])) < STILL
        own = dither(table.columns[f"{axis.name}_angle"], rest, step)
        scatter = np.sqrt(np.maximum(thinned * variance - step**2 / 12.0, own**2))
        read = turned + scatter * rng.standard_normal(len(t))
        name = f"{axis.name}_angle"
        exact[name] = turned
        noisy[name] = step * np.round(read / step) if step else read
        if (reported := f"{axis.name}_rate") in table.columns:
            exact[reported] = noisy[reported] = larger * table.columns[reported]
    return Stream(table.t, exact), Stream(table.t, noisy)


def dither(angle: np.ndarray, rest: np.ndarray, step: float) -> float:
    """The noise σ, rad, of an encoder before it rounds to steps q, by how its rests scatter.

    Rests lie anywhere between two codes: on average they scatter by σ² + q²/12 less the square of
    what rounding shifts their mean by, (q/πk)²/2·e^(−(2πkσ/q)²) of each k (Widrow, Kollár:
    Quantization Noise, 2008).
    """
    rough = np.diff(angle, 6)[rest[3:-3]]
    if not step or not len(rough):
        return 0.0
    k, ratios = np.arange(1.0, 51.0), np.linspace(0.0, 3.0, 301)
    shifted = np.exp(-((2.0 * np.pi * np.outer(ratios, k)) ** 2)) / (np.pi * k) ** 2 / 2.0
    scatter = ratios**2 + 1.0 / 12.0 - shifted.sum(axis=1)
    return float(step * np.interp(np.mean(rough**2) / 924.0 / step**2, scatter, ratios))
