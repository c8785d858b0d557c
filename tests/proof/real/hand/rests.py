"""Rests by hand: means of each rest, what no bias and matrix fits, and whether it wanders."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from schemas.recording import ACCEL, AXES, GYRO, Recording, Segment
from tests.proof.real.hand.measured import Measured, amplitude, batch_mean, strongest

# Two units on one rate table at the same time: what both see is the table's.

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


CHANNELS = GYRO + ACCEL
EARTH = 15.04107  # deg/h, Earth's rate against the stars
BATCHES = 10
DEG_PER_HOUR = float(np.degrees(3600.0))


def rests(recording: Recording) -> list[Segment]:
    """The labelled rests with a direction that points up."""
    return [
        each
        for each in recording.manifest.segments or ()
        if each.kind == "static" and each.up is not None
    ]


def readings(recording: Recording, segment: Segment) -> tuple[np.ndarray, np.ndarray]:
    """t (n,) and the six channels (n, 6) of a segment."""
    rows = recording.imu.rows(segment.t_start, segment.t_end)
    return recording.imu.t[rows], recording.imu.stack(CHANNELS, rows)


def up_of(segment: Segment) -> np.ndarray:
    """The label's direction (3,)."""
    assert segment.up is not None
    return np.eye(3)[AXES.index(segment.up[1])] * (1.0 if segment.up[0] == "+" else -1.0)


def means_of(recording: Recording) -> tuple[np.ndarray, np.ndarray]:
    """Directions (m, 3) that the labels say and medians (m, 6) of the m rests."""
    spans = rests(recording)
    medians = [np.median(readings(recording, each)[1], axis=0) for each in spans]
    return np.array([up_of(each) for each in spans]), np.array(medians)


def half_difference(recording: Recording, channel: int) -> Measured:
    """Half of what a channel reads up less down, deg/h; u by batches of each rest."""
    up, down = (
        batch_mean(readings(recording, each)[1][:, channel], BATCHES)
        for each in sorted(rests(recording), key=lambda one: one.up or "")[:2]
    )
    half = 0.5 * (up[0] - down[0]), 0.5 * float(np.hypot(up[1], down[1]))
    return Measured(half[0] * DEG_PER_HOUR, half[1] * DEG_PER_HOUR, "deg/h")


def vertical_earth_rate(recording: Recording) -> Measured:
    """Earth's rate about the local vertical, by the latitude that the manifest tells, deg/h."""
    latitude = recording.manifest.station.latitude_deg
    assert latitude is not None
    return Measured(EARTH * float(np.sin(np.radians(latitude))), 0.001, "deg/h")


def misfit(directions: np.ndarray, means: np.ndarray) -> np.ndarray:
    """What bias and matrix leave of the means (m, k) of rests: (m, k), least squares."""
    A = np.column_stack([np.ones(len(directions)), directions])
    return np.asarray(means - A @ np.linalg.lstsq(A, means, rcond=None)[0])


@dataclass(frozen=True)
class Wander:
    """Whether the biases of some channels wander within rests as they seem to between them.

    p_noise: probability of so much change within the rests by noise alone. p_walk: of so little
    by a random walk that would also make the misfit between the rests.
    """

    p_noise: float
    p_walk: float

    @property
    def verdict(self) -> str:
        """True, false or cannot tell, that a random walk is what the rests show."""
        if self.p_walk < 0.01:
            return "false"
        return "true" if self.p_noise < 0.01 else "cannot tell"


def wander(recording: Recording, channels: Sequence[int]) -> Wander:
    """Second halves less first halves of the rests beside the misfit between the rests.

    A walk of variance q a second makes q·T/3 between the means of the halves of T seconds, and
    about q·D between rests D apart. Noise by the scatter of one-second means.
    """
    spans, chosen = rests(recording), list(channels)
    directions, means = means_of(recording)
    freedom = len(directions) - 4
    between = (misfit(directions, means[:, chosen]) ** 2).sum(axis=0) / freedom
    apart = float(np.diff([each.t_start for each in spans]).mean())
    noise, walk = 0.0, 0.0
    for each in spans:
        t, values = readings(recording, each)
        values = values[:, chosen]
        seconds = np.array([part.mean(axis=0) for part in _seconds(t, values)])
        half = len(values) // 2
        change = (values[half:].mean(axis=0) - values[:half].mean(axis=0)) ** 2
        white = (np.diff(seconds, axis=0) ** 2).mean(axis=0) / 2.0 * 4.0 / len(seconds)
        walked = between / apart * (t[-1] - t[0]) / 3.0
        noise += float((change / white).sum())
        walk += float((change / (white + walked)).sum())
    count = len(spans) * len(chosen)
    return Wander(float(chi2.sf(noise, count)), float(chi2.cdf(walk, count)))


def _seconds(t: np.ndarray, values: np.ndarray) -> list[np.ndarray]:
    edges = np.searchsorted(t, np.arange(t[0], t[-1], 1.0))
    return np.split(values, edges[1:])[:-1]
