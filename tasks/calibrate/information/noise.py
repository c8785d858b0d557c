"""Noise of each channel over the longest rests: random walk and bias instability.

Source: IEEE Std 952, annex C: the random walk coefficient N is the Allan deviation of the white
part at 1 s; the bias instability is the minimum of the Allan deviation over √(2·ln 2/π) = 0.664.
"""

from dataclasses import dataclass

import numpy as np

from schemas.calibration import Information
from schemas.recording import AXES
from tasks.calibrate.information.allan import MIN_LEVELS, AllanCurve, allan_curve, white_noise
from tasks.calibrate.information.entry import entry, of_axes, student_k, unit_and_table
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    CHANNELS,
    GYRO_COLUMNS,
    SegmentMean,
    coarsely_quantised,
)
from tasks.specifications.estimate import DEG
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import Message, message
from tasks.words.rounding import USUAL_K

FLOOR = float(np.sqrt(2.0 * np.log(2.0) / np.pi))  # 0.664
AS_LONG = 0.9  # of the longest rest: rests as long as it is
GAP = 1.5  # sampling intervals: a longer step is a lost row
FALLING = 2.5  # times the minimum at a quarter of its averaging time: white noise makes half of it
SQRT_HOUR = 60.0  # √(3600 s)
HOUR = 3600.0


Quantity = tuple[str, str, float]  # key in the result, printed unit, factor from SI


@dataclass(frozen=True)
class AllanOfRests:
    """The Allan variances of a triad over its longest rests, SI.

    hidden: which channels (3,) have a step that hides their noise. count, seconds: how many rests,
    and how long the shortest of them is.
    """

    curve: AllanCurve
    hidden: np.ndarray
    count: int
    seconds: float


def noise_information(evidence: ClauseEvidence, rate_sensor: str) -> dict[str, Information]:
    """Random walk and bias instability of each triad that the recording has."""
    made = _of_triad(
        evidence,
        GYRO_COLUMNS,
        (f"{rate_sensor}_angle_random_walk", "deg/sqrt(h)", DEG * SQRT_HOUR),
        (f"{rate_sensor}_bias_instability", "deg/h", DEG * HOUR),
    )
    if rate_sensor == "gyro":
        made |= _of_triad(
            evidence,
            ACCEL_COLUMNS,
            ("accel_velocity_random_walk", "(m/s2)/sqrt(Hz)", 1.0),
            ("accel_bias_instability", "m/s2", 1.0),
        )
    return made


def _of_triad(
    evidence: ClauseEvidence, triad: slice, walk: Quantity, instability: Quantity
) -> dict[str, Information]:
    """Both quantities of three channels; none without a whole rest."""
    allan = allan_of_rests(evidence, triad)
    if allan is None:
        return {}
    curve, hidden = allan.curve, allan.hidden
    white, floor = np.full((2, 3), np.nan), np.full((4, 3), np.nan)
    if len(curve.tau) >= MIN_LEVELS:
        for i in np.flatnonzero(~hidden).tolist():
            white[:, i], floor[:, i] = _random_walk(curve, i), _bias_instability(curve, i)
    source = message("information-rests", count=allan.count, seconds=f"{allan.seconds:.0f}")
    coarse = of_axes("information-noise-hidden", _axes(hidden))
    averaged = [f"{AXES[i]} {floor[2, i]:.3g} s" for i in np.flatnonzero(np.isfinite(floor[2]))]
    longest = f"{curve.tau.max(initial=0.0):.3g}"
    return {
        walk[0]: _entry(
            walk,
            white,
            USUAL_K,
            message("information-random-walk", source=source),
            *unit_and_table(white[0]),
            *coarse,
            *of_axes("information-no-white-noise", _axes(np.isnan(white[0]) & ~hidden)),
        ),
        instability[0]: _entry(
            instability,
            floor[:2],
            student_k(floor[3]),
            message("information-bias-instability", source=source),
            *unit_and_table(floor[0]),
            *of_axes("information-averaging-times", averaged),
            *coarse,
            *of_axes("information-no-floor", _axes(np.isnan(floor[2]) & ~hidden), tau=longest),
        ),
    }


def allan_of_rests(evidence: ClauseEvidence, triad: slice) -> AllanOfRests | None:
    """The Allan variances of a triad (its columns among CHANNELS); None without a whole rest."""
    imu, rests = evidence.recording.imu, _longest(evidence, triad)
    if not rests:
        return None
    interval = float(np.median([rest.seconds / rest.rows for rest in rests]))
    return AllanOfRests(
        curve=allan_curve([imu.views(CHANNELS[triad], rest.place) for rest in rests], interval),
        hidden=np.any([coarsely_quantised(rest)[triad] for rest in rests], axis=0),
        count=len(rests),
        seconds=min(rest.seconds for rest in rests),
    )


def _longest(evidence: ClauseEvidence, triad: slice) -> list[SegmentMean]:
    """The rests as long as the longest, whole: no row left out of them and none lost."""
    whole = [
        s
        for s in (evidence.segments[i] for i in evidence.of_kind("static"))
        if s.left_out == 0
        and np.isfinite(evidence.recording.imu.views(CHANNELS[triad], s.place)).all()
        and (s.rows < 2 or s.intervals[1] < GAP * s.seconds / s.rows)
    ]
    longest = max((s.seconds for s in whole), default=0.0)
    return [s for s in whole if s.seconds >= AS_LONG * longest]


def _random_walk(curve: AllanCurve, channel: int) -> tuple[float, float]:
    """N of the white noise and its standard uncertainty, NaN where none shows."""
    noise = white_noise(curve, channel)
    if noise is None:
        return np.nan, np.nan
    value = np.sqrt(noise.density)
    return value, noise.u / (2.0 * value)


def _bias_instability(curve: AllanCurve, channel: int) -> tuple[float, float, float, float]:
    """Bias instability, its standard uncertainty, its averaging time (s) and degrees of freedom.

    NaN without floor.
    """
    variance = curve.variance[:, channel]
    level = int(variance.argmin())
    if level < 2 or not variance[level - 2] < FALLING * variance[level]:
        return np.nan, np.nan, np.nan, np.nan
    value, dof = np.sqrt(variance[level]) / FLOOR, curve.flicker_dof[level]
    return value, value / np.sqrt(2.0 * dof), curve.tau[level], dof


def _axes(which: np.ndarray) -> list[str]:
    return [AXES[i] for i in np.flatnonzero(which)]


def _entry(
    quantity: Quantity,
    value_and_u: np.ndarray,
    k: float,
    *sentences: Message,
) -> Information:
    key, unit, factor = quantity
    return entry(key, unit, *value_and_u, *sentences, factor=factor, k=k)
