"""Faults of the logged numbers: wrong codes, torn words, coarse steps, repeated rows."""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter
from scipy.special import ndtr
from scipy.stats import chi2, poisson

from schemas.discrepancy import FoundParameter
from schemas.recording import Recording, WrongCodes
from tasks.explain.events.event import (
    BLOCK,
    CHANNELS,
    TRIAD_NAMES,
    UNITS,
    Event,
    channel_names,
    peak_offset,
)
from tasks.explain.explanation import EVERY, TRIADS
from tasks.model.fit import plain_prediction
from tasks.motion.samples import in_blocks, interpolated
from tasks.motion.whole import Motion
from tasks.readings.codes import bug_in_words, size_in_words
from tasks.readings.judge import CERTAIN, in_course
from tasks.readings.lattice import OFF_CODE, Quantiser, quantiser_of
from tasks.words import Message, clauses, message

# Codes whose high byte is that of the row before.
#
# Where a high byte is late, readings are off by 256 codes when it changes. Where noise is not far
# below a byte no single reading tells it. But the low byte is right, and with what is expected it
# tells the high one; readings that are off by it then have the high byte of the row before far
# more often than of the row after. Noise knows no direction of time, and neither do spikes, held
# rows or a bias that jumps.

BYTE = 256.0  # codes
ABOUT = 25  # rows about one, most of which are right
FIT_ROUNDS = 3
SLOW = 64.0  # codes from row to row: faster, a delay has the high byte of the row before, too
MIN_TORN = 15
MIN_RATIO = 3.0  # of rows that have it of the row before to those of the row after
MAX_HELD = 0.2  # of the rows in which a change is expected


def torn_codes(code: np.ndarray, predicted: np.ndarray) -> np.ndarray | None:
    """By how many codes (n,) each reading is off; None where they are not torn.

    code, predicted: (n,) as read, and as expected without the fault.
    """
    known = np.isfinite(code) & np.isfinite(predicted)
    read, expected = np.where(known, code, 0.0), np.where(known, predicted, 0.0)
    low, right, near = np.mod(read, BYTE), read, expected
    slow = np.flatnonzero(known & (np.abs(np.gradient(expected)) < SLOW))
    if len(slow) < ABOUT or _stands_still(read, expected):
        return None
    for _ in range(FIT_ROUNDS):
        # On a ramp most rows may be off, and alike: what is expected there is told by rests beside.
        beyond = median_filter((right - expected)[slow], ABOUT, mode="nearest")
        near = expected + np.interp(np.arange(len(read)), slow, beyond)
        right = low + BYTE * np.round((near - low) / BYTE)
        if np.count_nonzero(read != right) < MIN_TORN:
            return None
    off = np.round((read - right) / BYTE)
    high = np.floor(right / BYTE)
    before, after = np.zeros_like(off), np.zeros_like(off)
    before[1:], after[:-1] = high[:-1] - high[1:], high[1:] - high[:-1]
    from_before, from_after = (off != 0.0) & (off == before), (off != 0.0) & (off == after)
    count = int((from_before & ~from_after)[slow].sum())
    chance = int((from_after & ~from_before)[slow].sum())
    torn = np.where(known & from_before, BYTE * off, 0.0)
    # Noise puts as many readings into the byte of the row after.
    odds = float(np.log(2.0)) * (count - MIN_RATIO * chance)
    return torn if odds > CERTAIN and in_course(code, code - torn) > 0.0 else None


def _stands_still(read: np.ndarray, expected: np.ndarray) -> bool:
    """Whether readings (n,) repeat the row before while something else is expected: both bytes are
    then of an earlier row.
    """
    moves = np.abs(np.diff(expected)) > 1.0
    return bool(np.mean(np.diff(read)[moves] == 0.0) > MAX_HELD) if moves.any() else False


# Codes joined wrongly or with a bit lost: readings are off by multiples of 2ᵇ codes.

P_VALUE = 1e-9  # of so many jumps to and fro with nothing between, at most


@dataclass(frozen=True)
class CodeFault(Event):
    """off: (n, 6) what the fault added to each reading."""

    off: np.ndarray

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return predicted + self.off

    def undone(self, readings: np.ndarray) -> np.ndarray:
        """Readings (n, 6) with the right codes."""
        return readings - self.off


def code_fault(recorded: Recording, right: Recording) -> CodeFault | None:
    """What was put right of the codes of a recording, as an event."""
    if not right.wrong_codes:
        return None
    off = recorded.imu.stack(CHANNELS) - right.imu.stack(CHANNELS)
    return _code_fault_event(right.wrong_codes, np.nan_to_num(off))


def find_torn_codes(readings: np.ndarray, motion: Motion) -> CodeFault | None:
    """Channels of readings (n, 6) whose high byte is that of the row before."""
    off, found, predicted = np.zeros_like(readings), list[WrongCodes](), None
    for c, reading in enumerate(readings.T):
        quantiser = quantiser_of(reading)
        if quantiser is None:
            continue
        step = quantiser.step
        predicted = plain_prediction(readings, motion) if predicted is None else predicted
        torn = torn_codes(reading / step, predicted[:, c] / step)
        if torn is not None:
            off[:, c] = torn * step
            share, nothing = float(np.mean(torn != 0.0)), np.zeros(len(readings), bool)
            found.append(WrongCodes(CHANNELS[c], "torn", BYTE, BYTE * step, share, nothing))
    return _code_fault_event(found, off) if found else None


def _code_fault_event(found: Sequence[WrongCodes], off: np.ndarray) -> CodeFault:
    channels = tuple(dict.fromkeys(CHANNELS.index(one.channel) for one in found))
    parameters = tuple(
        FoundParameter(
            name=f"jump_{one.channel}", value=one.jump, unit=_unit(one), u=1e-6 * one.jump
        )
        for one in found
    )
    texts = tuple(
        message(
            "events-code-fault-at", channel=message(f"channel-{one.channel}"),
            size=size_in_words(one), jump=f"{one.jump:.4g} {_unit(one)}",
            share=f"{100.0 * one.share:.2g}",
        )
        for one in found
    )  # fmt: skip
    bugs = clauses(list(_bugs(found)))
    return CodeFault(
        "code_fault", channels, parameters, P_VALUE,
        message("events-code-fault", channels=texts), off,
        title=message("events-code-fault-title", bugs=bugs, channels=channel_names(channels)),
    )  # fmt: skip


def _bugs(found: Sequence[WrongCodes]) -> Iterator[Message]:
    seen = {(one.bug, one.codes): one for one in found}
    yield from map(bug_in_words, seen.values())


def _unit(one: WrongCodes) -> str:
    return UNITS[CHANNELS.index(one.channel) // 3]


# Coarse quantisation: the output step is visible above the noise.
#
# A reading is the nearest code to x + noise. With Gaussian noise σ and step q its mean is x + Σ_k
# (−1)^k·(q/πk)·exp(−2π²k²σ²/q²)·sin(2πkx/q) (Widrow, Kollár: Quantization Noise, 2008). Above σ =
# 0.6 q nothing of it is left, and steps are of no concern.

FINE = 0.6  # noise per step from which a step shifts no mean by more than 3e-4 of it
NOISES = np.geomspace(0.04, 1.5, 40)  # σ in steps that are tried
PHASES = np.linspace(-0.5, 0.5, 33)[:-1]  # where the mean may lie between two codes
MAX_OFF = 6  # codes beside the middle one that are counted
CODES = np.arange(-MAX_OFF, MAX_OFF + 1)[:, None]
EDGES = np.arange(-MAX_OFF, MAX_OFF + 2)[:, None] - 0.5
CELLS = 256  # between two codes
MIN_INFORMATION = 0.3  # of a reading's without steps: one with less is left out
QUIET = 0.5  # of the least noise of the others of a triad
SHORT = 0.9  # of what an ideal unit reads: no scale factor is that far off
LARGE = (0.1, 1.0)  # rad/s and m/s²: beside less a bias counts
MOSTLY = 0.5  # of the largest ideal reading, from which on readings are compared with it
STEADY = 0.15  # steps: how far the predicted reading may move within a block
MAX_BLOCKS = 400  # that are looked at
QUANTISATION_FALSE_ALARM = 1e-4 / 6


@dataclass(frozen=True)
class Quantisation(Event):
    """quantisers: of each channel with visible steps. noises: σ before rounding, of each."""

    linear = False

    quantisers: tuple[Quantiser, ...]
    noises: tuple[float, ...]

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        rounded = predicted.copy()
        for channel, quantiser, noise in self._channels():
            rounded[:, channel] += rounding_bias(predicted[:, channel], quantiser, noise)
        return rounded

    def corrected(self, readings: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """Working readings of a fit by maximum likelihood (Fisher's scoring).

        Between two codes, far from the edge, a reading carries next to no information on the mean.
        """
        working = readings.copy()
        for channel, quantiser, noise in self._channels():
            slope, variance = _response(before[:, channel], quantiser, noise)
            informative = slope**2 * noise**2 > MIN_INFORMATION * variance
            step = (readings[:, channel] - after[:, channel]) / np.where(informative, slope, 1.0)
            step = np.clip(step, -quantiser.step, quantiser.step)
            working[:, channel] = np.where(informative, before[:, channel] + step, np.nan)
        return working

    def _channels(self) -> "zip[tuple[int, Quantiser, float]]":
        return zip(self.channels, self.quantisers, self.noises, strict=True)

    def noise_floor(self, noise: np.ndarray) -> np.ndarray:
        # Near a code nothing scatters.
        floored = noise.copy()
        for channel, quantiser, _ in self._channels():
            floored[:, channel] = np.fmax(floored[:, channel], quantiser.step / np.sqrt(12))
        return floored


@dataclass(frozen=True)
class NoiseEstimate:
    """The noise of one channel per step; p_value: that the steps do not show."""

    channel: int
    quantiser: Quantiser
    ratio: float
    p_value: float


def rounding_bias(mean: np.ndarray, quantiser: Quantiser, noise: float) -> np.ndarray:
    """How far rounding shifts the mean reading (n,), by the series above."""
    ratio = noise / quantiser.step
    phase = 2 * np.pi * (mean - quantiser.offset) / quantiser.step
    shift = np.zeros(len(mean))
    for k in range(1, int(np.clip(np.ceil(0.84 / ratio), 1, 60)) + 1):
        weight = (-1) ** k / (np.pi * k) * np.exp(-2 * (np.pi * k * ratio) ** 2)
        shift += weight * np.sin(k * phase)
    return quantiser.step * shift


def _response(
    mean: np.ndarray, quantiser: Quantiser, noise: float
) -> tuple[np.ndarray, np.ndarray]:
    """Derivative (n,) of the mean reading by the mean before rounding, and a reading's variance."""
    ratio = noise / quantiser.step
    phase = np.linspace(-0.5, 0.5, CELLS + 1)
    deviate = (EDGES - phase) / ratio
    probability = np.diff(ndtr(deviate), axis=0)
    middle = (CODES * probability).sum(axis=0)
    variance = (CODES**2 * probability).sum(axis=0) - middle**2
    density = np.exp(-0.5 * deviate**2) / (np.sqrt(2 * np.pi) * ratio)
    slope = -(CODES * np.diff(density, axis=0)).sum(axis=0)
    at = (mean - quantiser.offset) / quantiser.step
    within = np.nan_to_num(at - np.round(at))
    return (
        np.interp(within, phase, slope),
        np.interp(within, phase, np.maximum(variance, 1e-9)) * quantiser.step**2,
    )


def noise_estimates(
    readings: np.ndarray, predicted: np.ndarray, quantisers: Sequence[Quantiser | None]
) -> tuple[NoiseEstimate, ...]:
    """The noise per step of each channel with steps; predicted: (n, 6), NaN where not known."""
    every = (
        _noise_of(channel, quantiser, readings[:, channel], predicted[:, channel])
        for channel, quantiser in enumerate(quantisers) if quantiser is not None
    )  # fmt: skip
    return tuple(each for each in every if each is not None)


def cut_off(
    estimates: Sequence[NoiseEstimate],
    readings: np.ndarray,
    ideal: Callable[[int], np.ndarray],
) -> dict[int, float]:
    """The channels that lost noise and signal, as beyond a limit: what share of what an ideal unit
    would read they read. ideal: that, (n,), of a channel.

    Noise is missing where it is a small part of that of the others of the triad with the same step.
    """
    found = {}
    for one in estimates:
        alike = [
            other.ratio for other in estimates
            if other.channel // 3 == one.channel // 3 and other is not one
            and abs(other.quantiser.step / one.quantiser.step - 1.0) < OFF_CODE
        ]  # fmt: skip
        if alike and one.ratio < min(FINE, QUIET * min(alike)):
            least = LARGE[one.channel // 3]
            share = _share_read(readings[:, one.channel], ideal(one.channel), least)
            if 0.0 < share < SHORT:
                found[one.channel] = share
    return found


def _share_read(readings: np.ndarray, ideal: np.ndarray, least: float) -> float:
    """Median share that readings (n,) are of an ideal unit's where those are large, and larger than
    `least`; one without.
    """
    size = np.abs(ideal)
    large = np.isfinite(readings) & (size > max(least, MOSTLY * np.nanmax(size, initial=0.0)))
    return float(np.median(readings[large] / ideal[large])) if large.any() else 1.0


def find_quantisation(
    every: Sequence[NoiseEstimate], left_out: Collection[int] = ()
) -> Quantisation | None:
    """Steps that are visible above the noise, but for channels that are left out."""
    estimates = [
        each for each in every
        if each.ratio < FINE
        and each.p_value < QUANTISATION_FALSE_ALARM
        and each.channel not in left_out
    ]  # fmt: skip
    if not estimates:
        return None
    parameters, texts = zip(*_by_triad(estimates), strict=True)
    both = message("clause-sequence", first=texts[0], rest=texts[-1])
    return Quantisation(
        "coarse_quantisation", tuple(each.channel for each in estimates), parameters,
        min(1.0, 6 * min(each.p_value for each in estimates)),
        both if len(texts) > 1 else texts[0],
        tuple(each.quantiser for each in estimates),
        tuple(each.ratio * each.quantiser.step for each in estimates),
    )  # fmt: skip


def _noise_of(
    channel: int, quantiser: Quantiser, readings: np.ndarray, predicted: np.ndarray
) -> NoiseEstimate | None:
    """Maximum likelihood of the noise before rounding, each block with a mean of its own."""
    counts = _code_counts(quantiser, readings, predicted)
    if not len(counts):
        return None
    probability = np.diff(ndtr((EDGES - PHASES) / NOISES[:, None, None]), axis=1)
    log_odds = np.log(np.maximum(probability, 1e-12))  # (noises, codes, phases)
    likelihood = (counts @ log_odds).max(axis=2).sum(axis=1)
    best = int(likelihood.argmax())
    least = likelihood[NOISES >= FINE].max()
    p_value = float(chi2.sf(2 * (likelihood[best] - least), 1)) if NOISES[best] < FINE else 1.0
    ratio = NOISES[best] * (NOISES[1] / NOISES[0]) ** peak_offset(likelihood, best)
    return NoiseEstimate(channel, quantiser, float(ratio), p_value)


def _code_counts(quantiser: Quantiser, readings: np.ndarray, predicted: np.ndarray) -> np.ndarray:
    """How often each code (blocks, 2·MAX_OFF + 1) about the middle one, in steady blocks."""
    number = np.round((in_blocks(readings, BLOCK) - quantiser.offset) / quantiser.step)
    wander = np.ptp(in_blocks(predicted, BLOCK), axis=1) / quantiser.step
    number = number[np.isfinite(number).all(axis=1) & ~(wander > STEADY)]
    about = number - np.median(number, axis=1).round()[:, None]
    about = about[(np.abs(about) <= MAX_OFF).all(axis=1)].astype(int)
    about = about[:: len(about) // MAX_BLOCKS + 1]
    return np.asarray((about[:, :, None] == CODES[:, 0]).sum(axis=1))


def _by_triad(estimates: list[NoiseEstimate]) -> Iterator[tuple[FoundParameter, Message]]:
    """Each triad's step, which is exact but for the rounding of the codes, and in words."""
    for triad, name in enumerate(("gyro", "accel")):
        own = [each for each in estimates if each.channel in TRIADS[triad]]
        if not own:
            continue
        steps = [each.quantiser.step for each in own]
        step, u = float(np.mean(steps)), max(float(np.std(steps)), 1e-6 * steps[0])
        ratio = 1 / float(np.median([each.ratio for each in own]))
        yield (
            FoundParameter(name=name, value=step, unit=UNITS[triad], u=u),
            message(
                "events-quantisation", sensors=TRIAD_NAMES[triad],
                step=f"{step:.4g} {UNITS[triad]}", ratio=f"{ratio:.1f}",
            ),
        )  # fmt: skip


# Repeated samples: rows held, doubled or interpolated between their neighbours.
#
# A sensor that scatters from row to row does not read the same twice on every axis, nor stand on
# the straight line between its neighbours on every axis, but for rounding. How often chance does
# that follows from the steps of the output and from how much the readings about a row change.

WINDOW = 16  # rows on either side that tell how much the readings change
UNLIKELY = 0.02  # chance of a repeat in a row below which it is counted
MIN_REPEATS = 10
EXCESS = 5.0  # times what chance makes
REPEATS_FALSE_ALARM = 1e-7
LAGS = (37, 41, 53)  # rows: farther than any logger holds one
HALF = 0.51  # step: how far rounding puts a row off the line between its neighbours
ROUNDING = 1e-7  # of the largest reading: less is the rounding of a file
FEW = 0.2  # of the rows: doubled ones, after which later stamps slip
BETTER = 0.7  # of the misfit: what the right one of two clocks leaves at most


@dataclass(frozen=True)
class RepeatedSamples(Event):
    """source: (n, 6) the row whose reading each one holds, or its own. slipped: (n,) s by which
    stamps are late where rows were doubled; zero where they were held.
    """

    source: np.ndarray
    slipped: np.ndarray

    @property
    def held(self) -> np.ndarray:
        """(n, 6) bool: the reading of another row."""
        return np.asarray(self.source != np.arange(len(self.source))[:, None])

    def sampled_at(self, t: np.ndarray) -> np.ndarray:
        return t - self.slipped

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        if self.slipped.any():
            return interpolated(self.sampled_at(t), t, predicted)
        return np.take_along_axis(predicted, self.source, axis=0)


def find_repeats(
    readings: np.ndarray, motion: Motion, quantisers: Sequence[Quantiser | None]
) -> RepeatedSamples | None:
    """Rows of readings (n, 6) that repeat others; quantisers: of each channel."""
    held, between = (np.zeros(readings.shape, bool) for _ in range(2))
    size = np.nan_to_num(np.nanmax(np.abs(np.diff(readings, axis=0)), axis=0, initial=0.0))
    steps = np.array([0.0 if q is None else q.step for q in quantisers])
    steps = np.maximum(steps, ROUNDING * np.nanmax(np.abs(readings), axis=0, initial=0.0))
    for channels in (EVERY, *TRIADS):  # whole rows, then those of a triad alone
        own = list(channels)
        if not (size[own] > 0.0).all():
            continue
        known = (held | between)[:, own].all(axis=1)
        held[:, own] |= (_held_readings(readings[:, own], steps[own]) & ~known)[:, None]
        known = (held | np.roll(held, -1, axis=0) | between)[:, own].any(axis=1)
        rows = np.arange(float(len(readings)))  # a log that was brought to a higher rate afterwards
        for course in (motion.t, rows):
            straight = _between(course, readings[:, own], steps[own]) & ~known
            between[:, own] |= straight[:, None]
            if straight.any():
                break
    if not (held.any() or between.any()):
        return None
    return _repeats_event(held, between, _slipped(readings, motion, held))


def _held_readings(readings: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """(n,) bool: rows of some channels (n, k) that hold the row before; none where chance may."""
    change = np.full(readings.shape, np.nan)
    change[1:] = np.abs(np.diff(readings, axis=0))
    apart = (np.abs(readings[lag:] - readings[:-lag]) for lag in LAGS)
    return _beyond_chance(change / steps, 0.5, (off / steps for off in apart))


def _between(t: np.ndarray, readings: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """(n,) bool: rows of some channels on the line between their neighbours, by the stamps."""
    off = np.full(readings.shape, np.nan)
    share = ((t[1:-1] - t[:-2]) / (t[2:] - t[:-2]))[:, None]
    off[1:-1] = np.abs(readings[1:-1] - readings[:-2] - share * (readings[2:] - readings[:-2]))
    change = np.abs(np.diff(readings, axis=0)) < 0.5 * steps
    same = np.pad(change.all(axis=1), (1, 1))
    off[same[:-1] | same[1:]] = np.nan  # held rows are on a line, too
    middles = (
        readings[lag:-lag] - 0.5 * (readings[2 * lag :] + readings[: -2 * lag]) for lag in LAGS
    )
    return _beyond_chance(off / steps, HALF, (np.abs(middle) / steps for middle in middles))


def _beyond_chance(size: np.ndarray, within: float, distant: Iterable[np.ndarray]) -> np.ndarray:
    """(n,) bool: rows that are repeats in every channel, if they are more than chance makes.

    size: (n, k) steps by which each row is off a repeat; within: how many of them still are one.
    distant: the same for rows compared with others farther off, which no logger repeats. Chance
    as the readings about a row scatter; as they agree with distant ones; and as the rows are
    spread that are off by no more than a step, whatever their distribution, and be it one
    vibration that all channels share: it has no peak of its own at a repeat.
    """
    with np.errstate(invalid="ignore"):
        hit = np.asarray((size < within).all(axis=1))
        if np.count_nonzero(hit) < MIN_REPEATS:  # as in most recordings: chance need not be asked
            return np.zeros(len(hit), bool)
        near = np.asarray((size < within + 1.0).all(axis=1)) & ~hit
    reach = 2.0 * within / (np.sqrt(2.0 * np.pi) * _scale(hit, size))
    chance = np.prod(np.minimum(1.0, reach), axis=1)
    counted = chance < UNLIKELY
    seen = int((hit & counted).sum())
    usual = float(np.median([(each < within).all(axis=1).sum() for each in distant]))
    near_by = within * int((near & counted).sum())
    expected = EXCESS * max(float(chance[counted].sum()), near_by, usual)
    likely = seen < MIN_REPEATS or poisson.sf(seen - 1, expected) > REPEATS_FALSE_ALARM
    return np.zeros(len(hit), bool) if likely else hit


def _scale(hit: np.ndarray, size: np.ndarray) -> np.ndarray:
    """(n, k) root mean square of the size of rows that are no hit, on the quieter side of each."""
    used = ~hit & np.isfinite(size).all(axis=1)
    squares = np.vstack(
        [np.zeros(size.shape[1]), np.cumsum(np.where(used[:, None], size, 0.0) ** 2, axis=0)]
    )
    counts = np.concatenate([[0], np.cumsum(used)])
    rows = np.arange(len(hit))
    sides = []
    for first, last in ((rows - WINDOW, rows), (rows + 1, rows + 1 + WINDOW)):
        first, last = first.clip(0, len(hit)), last.clip(0, len(hit))
        number = counts[last] - counts[first]
        power = squares[last] - squares[first]
        mean = np.divide(
            power, number[:, None], out=np.zeros_like(power), where=number[:, None] > 0
        )
        sides.append(np.sqrt(np.maximum(mean, 0.0)))
    return np.maximum(np.minimum(*sides), 1e-300)


def _slipped(readings: np.ndarray, motion: Motion, held: np.ndarray) -> np.ndarray:
    """(n,) s by which stamps counted up from doubled rows are late; zero where the stamps fit."""
    nothing = np.zeros(len(held))
    doubled = held[:, :3].all(axis=1) & held[:, 3:].all(axis=1)
    if not doubled.any() or doubled.mean() > FEW:
        return nothing
    slipped = np.cumsum(doubled) * motion.interval
    late = motion.mapped(lambda values: _at(motion.t - slipped, motion.t, values))
    misfits = [
        np.nansum((readings - plain_prediction(readings, moved, held))[:, :3] ** 2)
        for moved in (motion, late)
    ]
    return slipped if misfits[1] < BETTER * misfits[0] else nothing


def _at(at: np.ndarray, t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values (n, …) at other times (n,) s."""
    flat = interpolated(at, t, values.reshape(len(values), -1))
    return flat.reshape(values.shape)


def _repeats_event(held: np.ndarray, between: np.ndarray, slipped: np.ndarray) -> RepeatedSamples:
    parameters, texts, channels = [], [], []
    own_row = np.arange(len(held))[:, None]
    source = np.maximum.accumulate(np.where(held, 0, own_row), axis=0)
    for triad, own in enumerate(TRIADS):
        for kind, rows in (("held", held[:, own[0]]), ("interpolated", between[:, own[0]])):
            if not rows.any():
                continue
            share, name = float(rows.mean()), ("gyro", "accel")[triad]
            doubled = kind == "held" and bool(slipped.any())
            way = "doubled" if doubled else kind
            u = float(np.sqrt(rows.sum())) / len(rows)
            parameters.append(FoundParameter(name=f"{way}_{name}", value=share, unit="1", u=u))
            texts.append(
                message(
                    f"events-repeats-{way}", sensors=TRIAD_NAMES[triad],
                    share=f"{100.0 * share:.2g}", count=int(rows.sum()),
                )
            )  # fmt: skip
            channels += [c for c in own if c not in channels]
    return RepeatedSamples(
        "repeated_samples", tuple(channels), tuple(parameters), REPEATS_FALSE_ALARM,
        message("events-repeats", kinds=tuple(texts)), source, slipped,
    )  # fmt: skip
