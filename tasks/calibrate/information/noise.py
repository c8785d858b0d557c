"""Noise of each channel over the longest rests: random walk and bias instability.

Source: IEEE Std 952, annex C: the random walk coefficient N is the Allan deviation of the white
part at 1 s; the bias instability is the minimum of the Allan deviation over √(2·ln 2/π) = 0.664.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from schemas.calibration import Information
from schemas.recording import ACCEL, AXES, GYRO, Recording
from tasks.calibrate.information.allan import (
    MIN_LEVELS,
    AllanCurve,
    WhiteNoise,
    allan_curve,
    white_noise,
)
from tasks.calibrate.information.entry import by_axis, entry, of_axes
from tasks.segments.summarise import SegmentMean, coarsely_quantised
from tasks.specifications.estimate import DEG
from tasks.specifications.evidence import Evidence
from tasks.words import Message, message

FLOOR = float(np.sqrt(2.0 * np.log(2.0) / np.pi))  # 0.664
AS_LONG = 0.9  # of the longest rest: rests as long as it is
GAP = 1.5  # sampling intervals: a longer step is a lost row
FALLING = 2.5  # times the minimum at a quarter of its averaging time: white noise makes half of it
SQRT_HOUR = 60.0  # √(3600 s)
HOUR = 3600.0


@dataclass(frozen=True)
class SensorTriad:
    """Three sensors and how their noise is printed.

    walk, instability: key of the result, its unit, and the factor from SI.
    """

    columns: tuple[str, ...]
    first: int
    walk: tuple[str, str, float]
    instability: tuple[str, str, float]


def _rate_sensors(name: str) -> SensorTriad:
    walk = (f"{name}_angle_random_walk", "deg/sqrt(h)", DEG * SQRT_HOUR)
    return SensorTriad(GYRO, 0, walk, (f"{name}_bias_instability", "deg/h", DEG * HOUR))


ACCELEROMETERS = SensorTriad(
    ACCEL,
    3,
    ("accel_velocity_random_walk", "(m/s2)/sqrt(Hz)", 1.0),
    ("accel_bias_instability", "m/s2", 1.0),
)


def noise_information(evidence: Evidence, rate_sensor: str) -> dict[str, Information]:
    """Random walk and bias instability of each triad that the recording has."""
    rates = _rate_sensors(rate_sensor)
    made: dict[str, Information] = {}
    for triad in (rates, ACCELEROMETERS) if rate_sensor == "gyro" else (rates,):
        if all(name in evidence.recording.imu.columns for name in triad.columns):
            made |= _of_triad(evidence, triad)
    return made


def _of_triad(evidence: Evidence, triad: SensorTriad) -> dict[str, Information]:
    recording = evidence.recording
    rests = _longest(evidence, triad)
    if not rests:
        return {}
    seconds = min(rest.seconds for rest in rests)
    interval = float(np.median([rest.seconds / rest.rows for rest in rests]))
    within = (recording.imu.rows(rest.segment.t_start, rest.segment.t_end) for rest in rests)
    readings = [recording.imu.channels(triad.columns, rows) for rows in within]
    curve = allan_curve(readings, interval)
    coarse = np.any([coarsely_quantised(rest) for rest in rests], axis=0)
    fine = [i for i in range(3) if not coarse[triad.first + i]]
    white = {i: white_noise(curve, i) for i in fine if len(curve.tau) >= MIN_LEVELS}
    source = message("information-rests", count=len(rests), seconds=f"{seconds:.0f}")
    hidden = [AXES[i] for i in range(3) if i not in fine]
    return {
        triad.walk[0]: _walk(triad, white, source, hidden),
        triad.instability[0]: _instability(triad, curve, white.keys(), source, hidden),
    }


def _longest(evidence: Evidence, triad: SensorTriad) -> list[SegmentMean]:
    """The rests as long as the longest, whole: no row left out of them and none lost."""
    whole = [
        s
        for s in (evidence.segments[i] for i in evidence.of_kind("static"))
        if s.left_out == 0
        and np.isfinite(s.mean[triad.first : triad.first + 3]).all()
        and _without_gap(evidence.recording, s)
    ]
    longest = max((s.seconds for s in whole), default=0.0)
    return [s for s in whole if s.seconds >= AS_LONG * longest]


def _without_gap(recording: Recording, rest: SegmentMean) -> bool:
    t = recording.imu.t[recording.imu.rows(rest.segment.t_start, rest.segment.t_end)]
    return bool(np.diff(t).max(initial=0.0) < GAP * rest.seconds / rest.rows)


def _walk(
    triad: SensorTriad,
    white: Mapping[int, WhiteNoise | None],
    source: Message,
    hidden: Sequence[str],
) -> Information:
    value, u = np.full(3, np.nan), np.full(3, np.nan)
    for i, noise in white.items():
        if noise is not None:
            value[i] = np.sqrt(noise.density)
            u[i] = noise.u / (2.0 * value[i])
    absent = [AXES[i] for i in range(3) if np.isnan(value[i]) and AXES[i] not in hidden]
    return _entry(
        triad.walk,
        value,
        u,
        message("information-random-walk", source=source),
        *of_axes("information-noise-hidden", hidden),
        *of_axes("information-no-white-noise", absent),
    )


def _instability(
    triad: SensorTriad,
    curve: AllanCurve,
    channels: Collection[int],
    source: Message,
    hidden: Sequence[str],
) -> Information:
    value, u, at = np.full(3, np.nan), np.full(3, np.nan), np.full(3, np.nan)
    for i in channels:
        level = int(curve.variance[:, i].argmin())
        least = float(curve.variance[level, i])
        if level >= 2 and curve.variance[level - 2, i] < FALLING * least:
            at[i], value[i] = curve.tau[level], np.sqrt(least) / FLOOR
            u[i] = value[i] / np.sqrt(2.0 * curve.flicker_dof[level])
    reached = [f"{AXES[i]} {at[i]:.3g} s" for i in range(3) if np.isfinite(at[i])]
    falling = [AXES[i] for i in range(3) if np.isnan(at[i]) and AXES[i] not in hidden]
    return _entry(
        triad.instability,
        value,
        u,
        message("information-bias-instability", source=source),
        *of_axes("information-averaging-times", reached),
        *of_axes("information-noise-hidden", hidden),
        *of_axes("information-no-floor", falling, tau=f"{curve.tau.max(initial=0.0):.3g}"),
    )


def _entry(
    what: tuple[str, str, float], value: np.ndarray, u: np.ndarray, *sentences: Message
) -> Information:
    key, unit, factor = what
    title = message(f"information-{key.replace('_', '-')}")
    return entry(title, unit, by_axis(factor * value), by_axis(factor * u), *sentences)
