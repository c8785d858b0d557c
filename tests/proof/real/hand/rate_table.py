"""Two units on one rate table at the same time: what both see is the table's."""

import numpy as np

from schemas.recording import AXES, GYRO, Recording, Segment
from tests.proof.real.hand.lines import amplitude, strongest
from tests.proof.real.hand.measured import Measured

BLOCKS = 6


def rate_runs(recording: Recording, axes: str = "xy") -> list[Segment]:
    """The labelled turns about some axes."""
    segments = recording.manifest.segments or ()
    return [each for each in segments if each.kind == "rate" and (each.axis or "-") in axes]


def series(recording: Recording, segment: Segment) -> tuple[np.ndarray, np.ndarray]:
    """t (n,) from zero and the gyro about the turning axis (n,) rad/s, its median taken off."""
    rows = recording.imu.rows(segment.t_start, segment.t_end)
    assert segment.axis is not None
    rate = recording.imu.columns[GYRO[AXES.index(segment.axis)]][rows]
    return recording.imu.t[rows] - recording.imu.t[rows][0], rate - np.median(rate)


def turns_per_second(segment: Segment) -> float:
    """How often the table goes round, 1/s."""
    assert segment.rate_deg_s is not None
    return abs(segment.rate_deg_s) / 360.0


def waves_per_turn(recording: Recording, low: float = 46.0, high: float = 50.0) -> Measured:
    """The strongest line between two counts a turn, as a count a turn, over all turns."""
    counts = []
    for segment in rate_runs(recording):
        turning = turns_per_second(segment)
        t, rate = series(recording, segment)
        counts.append(strongest(t, rate, low * turning, high * turning) / turning)
    return _by_scatter(counts, "1")


def ripple(recording: Recording, per_turn: float, rate_deg_s: float) -> Measured:
    """Amplitude of a wave N times a turn, in the turns at one rate, deg/s."""
    depths = []
    for segment in rate_runs(recording):
        if abs(segment.rate_deg_s or 0.0) == rate_deg_s:
            t, rate = series(recording, segment)
            at = per_turn * turns_per_second(segment)
            depths.append(float(np.degrees(amplitude(t, rate, at))))
    return _by_scatter(depths, "deg/s")


def together(one: Recording, other: Recording, per_turn: float) -> float:
    """Coherence, 0 to 1, of the wave N times a turn in two units: mean over their turns.

    Of the complex amplitudes in six blocks of each turn; without a common cause about 0.4.
    """
    values = []
    for mine, theirs in zip(rate_runs(one), rate_runs(other), strict=True):
        at = per_turn * turns_per_second(mine)
        a, b = (_blocks(*series(r, s), at) for r, s in ((one, mine), (other, theirs)))
        values.append(
            abs((a * b.conj()).sum()) / np.sqrt((abs(a) ** 2).sum() * (abs(b) ** 2).sum())
        )
    return float(np.mean(values))


def _blocks(t: np.ndarray, rate: np.ndarray, frequency: float) -> np.ndarray:
    wave = rate * np.exp(-2j * np.pi * frequency * t)
    return np.array([2.0 * block.mean() for block in np.array_split(wave, BLOCKS)])


def _by_scatter(values: list[float], unit: str) -> Measured:
    return Measured(
        float(np.mean(values)), float(np.std(values, ddof=1) / np.sqrt(len(values))), unit
    )
