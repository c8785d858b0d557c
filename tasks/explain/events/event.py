"""An event: an artefact of the readings that is no regressor, and how it changes what is read."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import ClassVar, Self

import numpy as np
from scipy.fft import next_fast_len, rfft

from schemas.discrepancy import FoundParameter
from schemas.recording import ACCEL, GYRO
from tasks.explain.explanation import EVERY, TRIADS
from tasks.model.fit import plain_prediction
from tasks.motion.samples import in_blocks, interpolated
from tasks.motion.whole import Motion
from tasks.words import Argument, Message, Sayable, message

CHANNELS = GYRO + ACCEL
UNITS = ("rad/s", "m/s2")  # of a triad
TRIAD_NAMES = (message("triad-gyro"), message("triad-accel"))


@dataclass(frozen=True)
class Event:
    """An artefact of the readings. A subclass says how it changes them.

    effect: its catalogue name, or `unnamed`. channels: 0 to 5, those affected.
    p_value: corrected for the number of hypotheses tested. linear: a small signal passes
    unchanged. indistinguishable: catalogue names that do the same to these readings. title: where
    more is to be said than the catalogue's.
    """

    linear: ClassVar[bool] = True

    effect: str
    channels: tuple[int, ...]
    parameters: tuple[FoundParameter, ...]
    p_value: float
    description: Message
    indistinguishable: tuple[str, ...] = field(default=(), kw_only=True)
    title: Sayable = field(default="", kw_only=True)

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        """The mean readings (n, 6) with the event, given those predicted (n, 6) without it.

        t: (n,) s.
        """
        return predicted

    def sampled_at(self, t: np.ndarray) -> np.ndarray:
        """When the readings stamped t (n,) s were taken, s."""
        return t

    def noise_floor(self, noise: np.ndarray) -> np.ndarray:
        """The noise (n, 6), at least that which the event itself makes."""
        return noise

    def corrected(self, readings: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """The readings (n, 6) without the event, NaN where they carry no information on that.

        before, after: what was predicted without the event and with it.
        """
        return readings - (after - before)


@dataclass(frozen=True)
class AddedSignal(Event):
    """An event that adds to the readings: each of its signals is (n, 6) at times (n,) s.

    frequencies: Hz, of signals that are steady lines.
    """

    signals: tuple[Callable[[np.ndarray], np.ndarray], ...]
    frequencies: tuple[float, ...] = field(default=(), kw_only=True)

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return predicted + sum(signal(t) for signal in self.signals)


@dataclass(frozen=True)
class Events:
    """All events of a recording, in the order in which they act on a reading.

    masked: (n, 6) bool, readings that a regression must not use. remarks: observations that are
    no mismatch.
    """

    events: tuple[Event, ...]
    masked: np.ndarray
    remarks: tuple[Message, ...] = ()

    @property
    def lines(self) -> tuple[float, ...]:
        """The frequencies (Hz) of the steady lines among them."""
        added = (event for event in self.events if isinstance(event, AddedSignal))
        return tuple(frequency for event in added for frequency in event.frequencies)

    def without_added(self) -> "Events":
        """The others than those that add to the readings: beside a fit these are found again."""
        kept = tuple(event for event in self.events if not isinstance(event, AddedSignal))
        return replace(self, events=kept)

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        """The mean readings (n, 6) with all events, given those predicted without any."""
        for event in self.events:
            predicted = event.applied(t, predicted)
        return predicted

    def corrected(self, t: np.ndarray, readings: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        """The readings (n, 6) without the events, NaN where they carry no information on that."""
        stages = [predicted]
        for event in self.events:
            stages.append(event.applied(t, stages[-1]))
        for event, (before, after) in reversed([*zip(self.events, pairwise(stages), strict=True)]):
            readings = event.corrected(readings, before, after)
        return readings


def channel_names(channels: tuple[int, ...]) -> Argument:
    """The channels as an argument of a message: a whole triad by its name, others one by one."""
    names: list[Message] = []
    for triad, name in zip(TRIADS, TRIAD_NAMES, strict=True):
        own = tuple(channel for channel in channels if channel in triad)
        each = [message(f"channel-{CHANNELS[channel]}") for channel in own]
        names += [name] if own == triad else each
    return tuple(names)


def significant_channels(size: np.ndarray, least: float) -> tuple[int, ...]:
    """The channels whose size (6,) over its uncertainty is significant; at least the strongest."""
    return tuple(np.flatnonzero(size > least).tolist()) or (int(size.argmax()),)


def amplitude_parameters(
    channels: tuple[int, ...], amplitudes: np.ndarray, u: np.ndarray, suffix: str = ""
) -> tuple[FoundParameter, ...]:
    """The size of complex amplitudes (6,) in some channels, named after them; u: (6,)."""
    return tuple(
        FoundParameter(
            name=CHANNELS[c] + suffix, value=float(np.abs(amplitudes[c])), unit=UNITS[c // 3],
            u=float(u[c]),
        )
        for c in channels
    )  # fmt: skip


# Plateaus: readings that stay constant while the prediction goes on.
#
# A limit of the raw output need not be one code of the file: calibration, temperature and filters
# spread it over hundreds of values, and each axis and side has its own. What shows it is the
# prediction of all that lies below, carried on beyond it.

NEAR = 0.03  # of the largest reading: what may be disturbed by a limit, at first
TOPMOST = 8  # readings above the one that counts as the largest, for spikes
BEYOND = 1.02  # times the limit, from where on a prediction is beyond it, be it ever so noisy
MIN_BEYOND = 12  # readings whose prediction is beyond
APPROACH = 0.7  # of the limit, from where on the readings must follow the prediction
MIN_APPROACH = 30
MOSTLY = 0.5  # of the readings at a limit, whose prediction is beyond
FLAT = 0.1  # change of the reading with the prediction beyond a limit; one without it
REACH = 4.0  # times the plateau's own scatter, by which the prediction passes it
QUIET = 0.5  # of the scatter below a limit: noise is cut off
BELOW = 0.9  # of the limit: a scale factor that bends would have lost most of it there, too
LOST_BELOW = 0.2  # of what is lost beyond a limit: more is no limit
MAX_SCATTER = 0.01  # of the limit
ROUNDS = 2
TRIMMED = (0.05, 0.95)


@dataclass(frozen=True)
class Plateau:
    """Where a channel's readings end on one side (1.0 above, −1.0 below).

    limit: of the readings times the side. scatter: of the readings there. noise: of those below.
    count: readings there.
    """

    channel: int
    side: float
    limit: float
    scatter: float
    noise: float
    count: int


def find_plateaus(
    readings: np.ndarray, motion: Motion, masked: np.ndarray
) -> tuple[tuple[Plateau, ...], np.ndarray, np.ndarray]:
    """Every plateau of readings (n, 6), which of them they disturb, and what the rest predicts.

    masked: (n, 6) bool, readings that are known to be disturbed.
    """
    sides = [(c, side) for c in EVERY for side in (1.0, -1.0)]
    limits = {(c, side): _largest(side * readings[:, c]) for c, side in sides}
    disturbed = masked.copy()
    for (c, side), limit in limits.items():
        disturbed[:, c] |= side * readings[:, c] > (1.0 - NEAR) * limit
    for _ in range(ROUNDS):
        predicted = plain_prediction(readings, motion, disturbed)
        some = (_plateau(readings, predicted, *key, limit) for key, limit in limits.items())
        found = tuple(plateau for plateau in some if plateau is not None)
        disturbed = masked.copy()
        for one in found:
            edge = one.limit - REACH * (one.scatter + one.noise)
            disturbed[:, one.channel] |= one.side * predicted[:, one.channel] > edge
        if not found:
            break
    return found, disturbed, predicted


def _largest(values: np.ndarray) -> float:
    """The largest of values (n,) but for a few; infinite where they are not positive."""
    known = values[np.isfinite(values)]
    if len(known) <= TOPMOST:
        return np.inf
    top = float(np.partition(known, -TOPMOST - 1)[-TOPMOST - 1])
    return top if top > 0.0 else np.inf


def _plateau(
    readings: np.ndarray, predicted: np.ndarray, channel: int, side: float, limit: float
) -> Plateau | None:
    """The plateau of a channel at a limit, if its readings have one there."""
    read, expected = side * readings[:, channel], side * predicted[:, channel]
    known = np.isfinite(read) & np.isfinite(expected)
    read, expected = read[known], expected[known]
    approach = (expected > APPROACH * limit) & (expected < (1.0 - NEAR) * limit)
    if approach.sum() < MIN_APPROACH:
        return None
    missed = float(np.sqrt(np.mean((read - expected)[approach] ** 2)))
    beyond = expected > min(BEYOND * limit, limit + REACH * missed)
    if beyond.sum() < MIN_BEYOND:
        return None
    level = float(np.median(read[beyond]))
    low, high = np.quantile(read[beyond], TRIMMED)
    scatter = float(high - low) / 3.29
    passed = float(np.quantile(expected[beyond], TRIMMED[1])) - level
    if scatter > MAX_SCATTER * limit or passed < REACH * max(scatter, missed):
        return None
    if not _mostly_beyond(read, beyond, level, scatter):
        return None
    lost = float(np.median((expected - read)[beyond]))
    abrupt = REACH * scatter < lost and _abrupt(read, expected, beyond, level - 2.0 * missed)
    if not (abrupt or _flat(read, expected, beyond, approach)):
        return None
    noise = float(np.std(np.diff((read - expected)[approach]))) / np.sqrt(2.0)
    return Plateau(channel, side, level, scatter, noise, int(beyond.sum()))


def _mostly_beyond(read: np.ndarray, beyond: np.ndarray, level: float, scatter: float) -> bool:
    """Whether what reads a limit is predicted beyond it.

    Of a motion that dwells at its highest rate an encoder's noise predicts a few readings beyond,
    and they alone would look as if they stood still.
    """
    there = read >= level - scatter
    return int((there & beyond).sum()) >= MOSTLY * int(there.sum())


def _flat(read: np.ndarray, expected: np.ndarray, beyond: np.ndarray, approach: np.ndarray) -> bool:
    """Whether readings beyond a limit follow the prediction no more, or have lost their noise."""
    off = expected[beyond] - expected[beyond].mean()
    slope = float(off @ read[beyond]) / max(float(off @ off), 1e-300)
    noise = (read - expected)[approach]
    if np.ptp(expected[beyond]) > REACH * 3.0 * float(np.std(noise)):
        return abs(slope) < FLAT
    return float(np.std(read[beyond])) < QUIET * float(np.std(noise))


def _abrupt(read: np.ndarray, expected: np.ndarray, beyond: np.ndarray, level: float) -> bool:
    """Whether readings that follow the prediction up to a level fall short of it beyond.

    A unit at rest reaches a limit in one position alone, where no slope is to be seen.
    """
    short = expected - read
    below = (expected > BELOW * level) & (expected < level)
    if below.sum() < MIN_BEYOND:
        return False
    return abs(float(short[below].mean())) < LOST_BELOW * float(np.median(short[beyond]))


# The residual of a regression, weighted by its noise.

SLOWEST = 1.0  # Hz; what is slower is left to the regression
LEVEL_BINS = 1024  # that the level of the noise about a line is estimated from
NEAREST = 1.0  # waves per recording, below half the sample rate: the mains of 50 Hz at 100 Hz
TAPER = 0.02  # of the recording, at either end
MAX_STRETCH = 4  # times its rows that a recording may last, gaps included


@dataclass(frozen=True)
class Residual:
    """Residuals at n rows, in rad/s and m/s².

    t: (n,) s, when the readings were taken. values: (n, 6), 0 where not known. weight: (n, 6) one
    over the noise, 0 where not known. motion: of the recording.
    """

    t: np.ndarray
    values: np.ndarray
    weight: np.ndarray
    motion: Motion

    @classmethod
    def of(cls, t: np.ndarray, values: np.ndarray, noise: np.ndarray, motion: Motion) -> Self:
        """From values (n, 6) and their noise (n, 6), NaN where either is not known."""
        known = np.isfinite(values) & (noise > 0)
        weight = np.divide(1.0, noise, out=np.zeros(noise.shape), where=known)
        return cls(t, np.where(known, values, 0.0), weight, motion)

    @cached_property
    def white(self) -> np.ndarray:
        """(n, 6) the values over their noise, 0 where not known."""
        return self.values * self.weight

    @cached_property
    def interval(self) -> float:
        """Time between rows, s."""
        return float(np.median(np.diff(self.t)))

    @property
    def span(self) -> float:
        """Time that the rows cover, s."""
        return float(self.t[-1] - self.t[0]) + self.interval

    def minus(self, signal: np.ndarray) -> Self:
        """The residual minus a signal (n, 6)."""
        return replace(self, values=np.where(self.weight > 0, self.values - signal, 0.0))

    def without(self, *events: Event) -> Self:
        """The residual with events removed as well."""
        left = self
        for event in events:
            left = left.minus(event.applied(self.t, np.zeros(self.values.shape)))
        return left

    def without_channels(self, channels: tuple[int, ...]) -> Self:
        """The same, with some channels not known."""
        kept = ~np.isin(np.arange(self.values.shape[1]), channels)
        return replace(self, values=self.values * kept, weight=self.weight * kept)


@dataclass(frozen=True)
class Spectrum:
    """power: (bins,) over that of the noise about it, summed over channels: of noise alone it is
    gamma distributed, with a shape of their number. level: (bins, channels) of the noise, over
    white noise. frequency: (bins,) Hz. channels: (k,) those that were recorded. nyquist: half the
    sample rate that its bins stand for, Hz."""

    power: np.ndarray
    level: np.ndarray
    frequency: np.ndarray
    channels: np.ndarray
    nyquist: float

    def level_at(self, frequency: float) -> np.ndarray:
        """Level (channels,) of the noise at a frequency in Hz."""
        return np.asarray(self.level[int(np.abs(self.frequency - frequency).argmin())])


def spectrum_of(residual: Residual) -> Spectrum:
    """The spectrum of the whitened residual, tapered at both ends."""
    t, white, interval = residual.t, residual.white, residual.interval
    channels = np.flatnonzero(white.any(axis=0))
    place = np.round((t - t[0]) / interval).astype(int)
    if place[-1] > MAX_STRETCH * len(t) or (np.diff(place) < 1).any():
        place = np.arange(len(t))
        interval = float(t[-1] - t[0]) / (len(t) - 1)  # rows count, not the usual step of stamps
    count = int(place[-1]) + 1
    edge = np.minimum(1.0, np.arange(1, count + 1) / max(TAPER * count, 1.0))
    taper = np.sin(0.5 * np.pi * np.minimum(edge, edge[::-1])).astype(np.float32) ** 2
    size = next_fast_len(2 * count, real=True)
    frequency = np.arange(size // 2 + 1) / (size * interval)
    inside = (frequency > SLOWEST) & (frequency < 0.5 / interval - NEAREST / (count * interval))
    total, level = np.zeros(int(inside.sum())), np.zeros((int(inside.sum()), len(channels)))
    for k, channel in enumerate(channels):
        even = np.zeros(count, np.float32)  # half the work, and exact enough
        even[place] = white[:, channel]
        transform = rfft((even - even.mean()) * taper, size)[inside]
        power = transform.real**2 + transform.imag**2
        noise = noise_level(power)
        total += np.divide(power, noise, out=np.zeros_like(power), where=noise > 0)
        level[:, k] = noise / max(float((taper[place] ** 2)[white[:, channel] != 0].sum()), 1.0)
    return Spectrum(total, level, frequency[inside], channels, 0.5 / interval)


def noise_level(power: np.ndarray) -> np.ndarray:
    """The mean power (bins,) of the noise about each bin: its neighbours' median over ln 2.

    0 where there are too few bins.
    """
    pieces = len(power) // LEVEL_BINS
    if pieces == 0:
        return np.zeros(len(power))
    level = np.median(power[: pieces * LEVEL_BINS].reshape(pieces, LEVEL_BINS), axis=1)
    middle = (np.arange(pieces) + 0.5) * LEVEL_BINS
    return np.asarray(np.interp(np.arange(len(power)), middle, level) / np.log(2))


def peak_offset(values: np.ndarray, peak: int) -> float:
    """Where the parabola through a peak and its neighbours has its top, in steps from it."""
    if not 0 < peak < len(values) - 1:
        return 0.0
    before, middle, after = values[peak - 1 : peak + 2]
    bend = before - 2 * middle + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend < 0 else 0.0


# The noise of a sample by the rate, and the level of a spectrum by the state of the motion.
#
# A table in motion shakes what stands on it; what is left of the motion itself is largest where
# the rate changes.

BLOCK = 64  # rows, within which the noise is estimated
RATE_CLASSES = np.array(
    [0.0, 0.02, 0.1, 0.3, 0.6, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, np.inf]
)  # rad/s
MIN_BLOCKS = 3  # that the noise of a class of rates is estimated from
DEAD = 1e-10  # rad/s, m/s²: less scatter is the rounding of sums

REST, ROTATION, RATE_CHANGE = range(3)
STEADY = 0.02  # rad/s: how far the rate may move within a second where it counts as steady
SETTLING = 5.0  # s after a change of rate that still count to it
MIN_VALUES = 12  # that the level of a state is estimated from
MAX_MEDIAN_ROWS = 200  # evenly spread


def noise_by_rate(residual: np.ndarray, motion: Motion) -> np.ndarray:
    """Standard deviation (n, 6) of a sample at each row's rate: vibration grows with the rate.

    residual: (n, 6), NaN where unknown. The median over the blocks of a class of rates, so that
    a few disturbed blocks do not matter, linear in the rate between the classes.
    """
    if len(residual) < BLOCK:
        return np.full(residual.shape, np.nan)
    scatter = _block_scatter(residual)
    speed = np.linalg.norm(motion.rate, axis=1)
    speeds = in_blocks(speed, BLOCK).mean(axis=1)
    return np.column_stack([_interpolated_noise(column, speeds, speed) for column in scatter.T])


def without_dead(noise: np.ndarray) -> np.ndarray:
    """The noise (n, 6), NaN in a channel that never scatters: it is dead."""
    return np.where(np.nan_to_num(noise).max(axis=0) > DEAD, noise, np.nan)


def _block_scatter(residual: np.ndarray) -> np.ndarray:
    """Standard deviation (blocks, 6) about a straight line within each whole block of rows."""
    cut = in_blocks(residual, BLOCK)
    line = np.linspace(-1.0, 1.0, BLOCK)
    about = cut - cut.mean(axis=1, keepdims=True)
    slope = np.einsum("bni,n->bi", about, line) / (line @ line)
    total = (about**2).sum(axis=1) - slope**2 * (line @ line)
    return np.sqrt(np.maximum(total, 0.0) / (BLOCK - 2))


def _interpolated_noise(scatter: np.ndarray, speeds: np.ndarray, speed: np.ndarray) -> np.ndarray:
    """Noise (n,) at each speed (n,), from the scatter and the mean speed of blocks (b,)."""
    good = np.isfinite(scatter) & np.isfinite(speeds)
    if not good.any():
        finite = scatter[np.isfinite(scatter)]
        return np.full(len(speed), np.median(finite) if len(finite) else np.nan)
    scatter, speeds = scatter[good], speeds[good]
    label = np.digitize(speeds, RATE_CLASSES)
    classes = [label == k for k in np.unique(label)]
    classes = [c for c in classes if c.sum() >= MIN_BLOCKS or c.all()]
    if not classes:
        return np.full(len(speed), np.median(scatter))
    at = [float(np.median(speeds[c])) for c in classes]
    return np.interp(np.nan_to_num(speed), at, [float(np.median(scatter[c])) for c in classes])


def motion_states(motion: Motion, at: np.ndarray) -> np.ndarray:
    """The state (m,) at times at (m,) s, rising. Unknown motion counts as a change of rate."""
    rate = interpolated(at, motion.t, np.nan_to_num(motion.rate))
    step = float(np.median(np.diff(at))) if len(at) > 1 else 1.0
    half = max(1, round(0.5 / step))
    padded = np.pad(rate, ((half, half), (0, 0)), mode="edge")
    changes = np.abs(padded[2 * half :] - padded[: -2 * half]).max(axis=1) > STEADY
    changes = changes | (np.interp(at, motion.t, motion.known.astype(float)) < 1)
    changes = changes | (np.diff(at, prepend=-np.inf) > 1.5 * step)
    latest = np.maximum.accumulate(np.where(changes, at, -np.inf))
    steady = np.where(np.linalg.norm(rate, axis=1) > STEADY, ROTATION, REST)
    return np.where(at - latest < SETTLING, RATE_CHANGE, steady)


def median_by_state(power: np.ndarray, state: np.ndarray) -> np.ndarray:
    """The median (m, k) of power (m, k) over each motion state; infinite in a short one."""
    level = np.ones(power.shape, power.dtype)
    for number in np.unique(state):
        rows = state == number
        level[rows] = _median(power[rows]) if rows.sum() >= MIN_VALUES else np.inf
    return level


def equalised(power: np.ndarray, state: np.ndarray, min_rows: int) -> np.ndarray:
    """Power (m, k), divided down where one interval is louder than its motion state as a whole.

    An interval lies between two changes of state. One of fewer than `min_rows` rows stays as it
    is: the transient that is looked for may fill it.
    """
    usual = {number: _median(power[state == number]) for number in np.unique(state)}
    even = power.copy()
    edges = np.flatnonzero(np.diff(state)) + 1
    for start, stop in zip(np.append(0, edges), np.append(edges, len(state)), strict=True):
        if stop - start >= min_rows:
            own, among = _median(power[start:stop]), usual[state[start]]
            louder = np.divide(own, among, out=np.ones_like(own), where=among > 0)
            even[start:stop] /= np.maximum(louder, 1.0)
    return even


def _median(power: np.ndarray) -> np.ndarray:
    """The median (k,) of power (m, k), over evenly spread rows where there are many."""
    return np.asarray(np.median(power[:: len(power) // MAX_MEDIAN_ROWS + 1], axis=0))
