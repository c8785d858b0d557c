"""What a firmware does at rest: a bias that it takes off, and a dead zone."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.special import ndtr
from scipy.stats import chi2

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import CHANNELS, UNITS, Event, channel_names, noise_by_rate
from tasks.explain.explanation import GYROS
from tasks.model.fit import inverse, plain_prediction
from tasks.model.terms.standard import regressors
from tasks.motion.samples import first_order_lag, in_blocks
from tasks.motion.whole import Motion
from tasks.readings.lattice import Quantiser
from tasks.readings.plausibility import runs
from tasks.words import message

# Gyro bias that the firmware estimates whenever it takes the unit to be at rest, and subtracts.
#
# While no gyro has left ± `quiet` for `wait` seconds, an estimate b follows the readings r with
# the time constant τ; what is written is y = r − b. So db/dt = y/τ there, and b is 1/τ times the
# integral of what was written in those rows: a regressor that the recording itself holds, noise
# included. A slow motion within ± `quiet` is taken for bias, and stays in all later readings.

QUIETS = tuple(np.geomspace(0.01, 0.16, 5).tolist())  # rad/s
WAITS = (0.25, 0.5, 1.0, 2.0)  # s
STARTS = 3  # of them that are refined
STEPS = (0.5, 0.25, 0.1, 0.03)  # relative, by which each is refined
BRIEFEST = 0.2  # s of waiting: less is no rest
FOLLOWED = 10.0  # time constants at rest, in all: in less no estimate is told from a step
LONGEST = 5.0  # s: slower estimates are not told from a bias that drifts
BLOCK = 8  # rows, in whose means readings are compared
CELLS = (1.0, 5.0, 20.0)  # s, within which what is left may go together
LAGS = (0.3, 1.0, 3.0)  # s of a reference, or of what smooths it
CLEAR_BIAS = 10.0  # standard deviations
ALIKE = 0.3  # of 1/τ: axes and halves that differ by less have one estimate
APART = 4.0  # standard deviations by which they may differ
TELLING = 0.05  # of the information on 1/τ, from which on an axis or a half must agree


@dataclass(frozen=True)
class BiasAtRest(Event):
    """t: (n,) s. taken_off: (n, 3) rad/s, the estimate that the readings lack."""

    t: np.ndarray
    taken_off: np.ndarray

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        read = predicted.copy()
        for axis in GYROS:
            read[:, axis] -= np.interp(t, self.t, self.taken_off[:, axis])
        return read


@dataclass(frozen=True)
class _Follows:
    """Readings that an estimate with some `quiet` and `wait` explains.

    rate: 1/τ of all axes. gain: whitened sum of squares that it removes. information, rates: (5,)
    on 1/τ of each axis, then of the earlier and the later half of the information.
    """

    quiet: float
    wait: float
    gain: float
    rate: float
    information: np.ndarray
    rates: np.ndarray


def find_bias_at_rest(readings: np.ndarray, motion: Motion) -> BiasAtRest | None:
    """The bias estimated at rest of readings (n, 6); None where that does not explain them."""
    fit = _Whitened.of(readings, motion)
    if fit is None:
        return None
    best = _best(fit)
    if best.gain < CLEAR_BIAS**2 or best.rate * LONGEST < 1.0:
        return None
    if fit.rested(best.quiet, best.wait).sum() * fit.interval * best.rate < FOLLOWED:
        return None
    dispersion = fit.dispersion(best)
    telling = best.information > TELLING * best.information[-2:].sum()
    off = np.abs(best.rates - best.rate)[telling]
    u = np.sqrt(dispersion / best.information[telling])
    alike = (off < np.maximum(APART * u, ALIKE * best.rate)).all()
    if best.gain < CLEAR_BIAS**2 * dispersion or not alike:
        return None
    return _event(fit, best, dispersion)


def _best(fit: "_Whitened") -> _Follows:
    """The `quiet` and `wait` that explain most; none is refined where none explains anything."""
    tried = [fit.follows(*one) for one in product(QUIETS, WAITS)]
    first = sorted(tried, key=lambda one: -one.gain)[:STARTS]
    refined = []
    for best in first if first[0].gain > CLEAR_BIAS else ():
        for step in STEPS:
            near = [fit.follows(*one) for one in _near(best, step)]
            best = max(near, key=lambda one: one.gain)
        refined.append(best)
    return max((*first, *refined), key=lambda one: one.gain)


def _near(best: _Follows, step: float) -> Iterator[tuple[float, float]]:
    scales = (1.0 - step, 1.0, 1.0 + step)
    for q, w in product(scales, scales):
        yield q * best.quiet, max(w * best.wait, BRIEFEST)


@dataclass(frozen=True)
class _Whitened:
    """Gyro readings in blocks, divided by their noise, minus their fit by the standard's model.

    written: (n, 3) readings; size: (n,) the largest of a row. used: rows that form blocks. weight,
    left: (blocks, 3). bases: for each axis (blocks, k) orthonormal columns of the model.
    """

    t: np.ndarray
    written: np.ndarray
    size: np.ndarray
    interval: float
    used: np.ndarray
    weight: np.ndarray
    left: np.ndarray
    bases: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, readings: np.ndarray, motion: Motion) -> "_Whitened | None":
        """None where too little is known of gyros or motion."""
        written = readings[:, list(GYROS)]
        known = np.isfinite(written).all(axis=1) & motion.felt[:, list(GYROS)].all(axis=1)
        used = np.flatnonzero(known)
        if len(used) < 100 * BLOCK:
            return None
        noise = noise_by_rate(readings - plain_prediction(readings, motion), motion)
        noise = noise[:, list(GYROS)]
        if not (noise[used] > 0.0).all():
            return None
        weight = np.sqrt(BLOCK) / _means(noise[used])
        bases, left = [], np.empty(weight.shape)
        for axis in GYROS:
            columns = np.column_stack([regressors(motion, axis), _of_reference(motion, axis)])
            columns = _means(columns[used]) * weight[:, axis, None]
            base = np.linalg.svd(columns, full_matrices=False)
            kept = base[1] > 1e-9 * base[1][0]
            bases.append(base[0][:, kept])
            own = _means(written[used, axis, None])[:, 0] * weight[:, axis]
            left[:, axis] = own - bases[axis] @ (bases[axis].T @ own)
        size = np.where(known, np.abs(np.nan_to_num(written)).max(axis=1), np.inf)
        interval = float(np.median(np.diff(motion.t)))
        return cls(
            motion.t, np.nan_to_num(written), size, interval, used, weight, left, tuple(bases)
        )

    def rested(self, quiet: float, wait: float) -> np.ndarray:
        """(n,) bool, whether the unit was believed to rest."""
        rows = np.arange(len(self.size))
        moved = np.maximum.accumulate(np.where(self.size < quiet, -1, rows))
        return np.asarray(rows - moved > wait / self.interval)

    def integral(self, quiet: float, wait: float) -> np.ndarray:
        """(n, 3) rad, of what was written while the unit was believed to rest."""
        written = np.where(self.rested(quiet, wait)[:, None], self.written, 0.0)
        return np.asarray(written.cumsum(axis=0) * self.interval)

    def regressor(self, quiet: float, wait: float) -> np.ndarray:
        """(blocks, 3) the integral over the noise, minus its projection on the model."""
        found = _means(self.integral(quiet, wait)[self.used]) * self.weight
        for axis, base in enumerate(self.bases):
            found[:, axis] -= base @ (base.T @ found[:, axis])
        return found

    def follows(self, quiet: float, wait: float) -> _Follows:
        """How much an estimate explains; nothing where the readings move away from it."""
        column = self.regressor(quiet, wait)
        information, pull = column**2, -column * self.left
        course = information.sum(axis=1).cumsum()
        half, total = int(np.searchsorted(course, 0.5 * course[-1])), float(course[-1])
        rate = max(float(pull.sum()) / total, 0.0) if total > 0.0 else 0.0
        information, pull = (
            np.append(each.sum(axis=0), [each[:half].sum(), each[half:].sum()])
            for each in (information, pull)
        )
        rates = np.divide(pull, information, out=np.zeros(5), where=information > 0.0)
        return _Follows(quiet, wait, rate**2 * total, rate, information, rates)

    def dispersion(self, found: _Follows) -> float:
        """Mean squared residual of means over cells, relative to white noise; at least one."""
        left = self.left + found.rate * self.regressor(found.quiet, found.wait)
        rows = [max(1, round(cell / (BLOCK * self.interval))) for cell in CELLS]
        cells = [in_blocks(left, count).mean(axis=1) * np.sqrt(count) for count in rows]
        return max(1.0, *(float(np.mean(each**2)) for each in cells))


def _of_reference(motion: Motion, axis: int) -> np.ndarray:
    """(n, k) what errors of a reference follow: its rate late, its angle, its acceleration."""
    rate = np.nan_to_num(motion.rate[:, axis])
    late = [first_order_lag(rate, motion.interval, lag) for lag in LAGS]
    acceleration = np.nan_to_num(motion.acceleration[:, axis])
    return np.column_stack([*late, rate.cumsum() * motion.interval, acceleration])


def _means(values: np.ndarray) -> np.ndarray:
    """(blocks, k) of values (n, k)."""
    return np.asarray(in_blocks(values, BLOCK).mean(axis=1))


def _event(fit: _Whitened, found: _Follows, dispersion: float) -> BiasAtRest:
    tau = 1.0 / found.rate
    u = float(np.sqrt(dispersion / found.information[-2:].sum())) * tau**2
    parameters = (
        FoundParameter(name="wait", value=found.wait, unit="s", u=STEPS[-1] * found.wait),
        FoundParameter(name="quiet", value=found.quiet, unit="rad/s", u=STEPS[-1] * found.quiet),
        FoundParameter(name="tau", value=tau, unit="s", u=u),
    )
    description = message(
        "events-bias-at-rest", channels=channel_names(GYROS), wait=f"{found.wait:.2g}",
        quiet=f"{found.quiet:.2g}", tau=f"{tau:.2g}",
    )  # fmt: skip
    p_value = float(np.exp(-0.5 * found.gain / dispersion))
    taken_off = found.rate * fit.integral(found.quiet, found.wait)
    return BiasAtRest("dead_zone", GYROS, parameters, p_value, description, fit.t, taken_off)


# A dead zone: readings below a threshold are set to zero, or the bias is taken off at rest.
#
# Larger readings stay as they are, or have the threshold taken off.
#
# Where readings about zero are missing while others as small as the threshold abound, and those
# that read zero are predicted to lie within it, they were set to zero. Where the means of many
# rests lie nearer to zero than the noise of so many samples lets them, the bias was estimated and
# taken off.

ZERO = 1e-9  # of the largest reading: what counts as set to zero
MIN_ZEROS, MIN_BESIDE = 50, 25  # readings at zero, and from the threshold to some times as much
BESIDE = 4.0  # times the threshold: three times as wide as what is missing
MIN_CODES = 3  # below the threshold: fewer are the step of the output
MIDDLE = (1.2, 1.8)  # of the threshold: a step as wide would leave nothing there, either
MIN_MIDDLE = 3
WITHIN, MIN_WITHIN = 4.0, 0.95  # errors by which a zero may lie beyond, and the share that does not
CLEAR_THRESHOLD = 10.0  # times its uncertainty: a threshold that is taken off
ROUNDS = 2
STILL, MIN_REST = 0.005, 200  # rad/s, rows of a rest
CALM = 0.5  # s of a mean rate
MIN_RESTS = 8
SOON = 0.4  # s from the start of a rest: firmware waits longer
GONE, LASTING = 4.0, 3.0  # of a mean's variance that is left, and of what is left that was there
RINGING = 2.0  # times the noise: a fixture that still swings as a rest begins has no constant bias
DITHERED = 0.5  # step: less noise lets means lie anywhere
SIGNIFICANT = 1e-7


@dataclass(frozen=True)
class DeadZone(Event):
    """thresholds, noise: by channel; none if only the bias is subtracted at rest. less: the
    channels whose larger readings are reduced by the threshold.
    """

    linear = False

    thresholds: dict[int, float]
    noise: dict[int, float]
    less: frozenset[int] = frozenset()

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        kept = predicted.copy()
        for channel, threshold in self.thresholds.items():
            lost = mean_within(predicted[:, channel], threshold, self.noise[channel])
            kept[:, channel] -= lost
            if channel in self.less:
                spread = self.noise[channel]
                above = ndtr((predicted[:, channel] - threshold) / spread)
                below = ndtr((-threshold - predicted[:, channel]) / spread)
                kept[:, channel] -= threshold * (above - below)
        return kept


def mean_within(mean: np.ndarray, threshold: float, noise: float) -> np.ndarray:
    """What readings within ± a threshold add to the mean (n,) of readings with normal noise."""
    low, high = (-threshold - mean) / noise, (threshold - mean) / noise
    density = np.exp(-0.5 * high**2) - np.exp(-0.5 * low**2)
    share = ndtr(high) - ndtr(low)
    return np.asarray(mean * share - noise * density / np.sqrt(2.0 * np.pi))


def find_dead_zone(
    readings: np.ndarray, motion: Motion, quantisers: Sequence[Quantiser | None]
) -> tuple[DeadZone | None, np.ndarray]:
    """The dead zone of readings (n, 6), and which of them (n, 6) bool say nothing for it."""
    masked = np.zeros(readings.shape, bool)
    holes = {
        c: hole
        for c, quantiser in enumerate(quantisers)
        if (hole := _hole(readings[:, c], quantiser)) is not None
    }
    less = {
        c: found
        for c, quantiser in enumerate(quantisers)
        if not holes and (found := _taken_off(readings[:, c], motion, c, quantiser)) is not None
    }
    if holes or less:
        return _set_to_zero(readings, motion, holes | less, frozenset(less))
    rests, soon = _rests(motion), max(1, round(SOON / max(motion.interval, 1e-9)))
    zeroed = tuple(
        c
        for c in GYROS
        if len(rests) >= MIN_RESTS and _zeroed(readings[:, c], rests, quantisers[c], soon)
    )
    if not zeroed:
        return None, masked
    for rows in rests:
        masked[np.ix_(rows, np.array(zeroed))] = True
    parameter = FoundParameter(name="rests", value=float(len(rests)), unit="1", u=0.0)
    description = message("events-zeroed", rests=len(rests), channels=channel_names(zeroed))
    return DeadZone("dead_zone", zeroed, (parameter,), SIGNIFICANT, description, {}, {}), masked


def _hole(reading: np.ndarray, quantiser: Quantiser | None) -> tuple[float, float] | None:
    """The threshold about zero below which only zero is read, and how well it is known."""
    size = np.abs(reading[np.isfinite(reading)])
    if not len(size) or not size.max() > 0.0:
        return None
    zero = size <= ZERO * size.max()
    if zero.sum() < MIN_ZEROS or zero.all():
        return None
    threshold = float(size[~zero].min())
    beside = size[~zero & (size <= BESIDE * threshold)]
    middle = (beside > MIDDLE[0] * threshold) & (beside < MIDDLE[1] * threshold)
    step = 0.0 if quantiser is None else quantiser.step
    if threshold < (MIN_CODES - 0.5) * step:
        return None
    if len(beside) < MIN_BESIDE or middle.sum() < MIN_MIDDLE:
        return None
    return threshold, threshold / len(beside) + step


def _set_to_zero(
    readings: np.ndarray, motion: Motion, holes: dict[int, tuple[float, float]],
    less: frozenset[int] = frozenset(),
) -> tuple[DeadZone | None, np.ndarray]:  # fmt: skip
    """The event of the holes whose zeros are predicted to lie within, and the readings there."""
    zero = np.abs(readings) <= ZERO * np.nanmax(np.abs(readings), axis=0, initial=0.0)
    masked = np.zeros(readings.shape, bool)
    masked[:, list(holes)] = zero[:, list(holes)]
    noise: dict[int, float] = {}
    error: dict[int, float] = {}  # of the prediction, the reference's own included
    whole = readings.copy()
    for c in less:
        whole[:, c] += np.sign(whole[:, c]) * holes[c][0]
    predicted = plain_prediction(whole, motion, masked)
    for _ in range(ROUNDS):
        masked[:] = False
        for c, (threshold, _) in holes.items():
            beyond = np.abs(predicted[:, c]) > 2.0 * threshold
            left = (whole - predicted)[beyond, c]
            error[c] = _deviation(left)
            noise[c] = max(_deviation(np.diff(left)) / np.sqrt(2.0), 1e-3 * threshold)
            masked[:, c] = zero[:, c] | (np.abs(predicted[:, c]) < threshold + WITHIN * noise[c])
        predicted = plain_prediction(whole, motion, masked)
    found = {
        c: hole
        for c, hole in holes.items()
        if _within(predicted[zero[:, c], c], hole[0] + WITHIN * max(noise[c], error[c]))
    }
    masked[:, [c for c in range(readings.shape[1]) if c not in found]] = False
    if not found:
        return None, masked
    parameters = tuple(
        FoundParameter(
            name=f"threshold_{CHANNELS[c]}", value=threshold, unit=UNITS[c // 3],
            u=max(width / np.sqrt(12.0), 1e-6 * threshold),
        )
        for c, (threshold, width) in found.items()
    )  # fmt: skip
    limits = tuple(
        message(
            "events-dead-zone-less" if c in less else "events-dead-zone-at",
            channel=message(f"channel-{CHANNELS[c]}"),
            threshold=f"{threshold:.4g} {UNITS[c // 3]}", count=int(zero[:, c].sum()),
        )
        for c, (threshold, _) in found.items()
    )  # fmt: skip
    # Of so many codes below the threshold a reading is the middle one by chance.
    p_value = float(MIN_CODES) ** -float(sum(zero[:, c].sum() for c in found))
    return DeadZone(
        "dead_zone", tuple(found), parameters, p_value, message("events-dead-zone", limits=limits),
        {c: threshold for c, (threshold, _) in found.items()}, noise, less,
    ), masked  # fmt: skip


def _taken_off(
    reading: np.ndarray, motion: Motion, channel: int, quantiser: Quantiser | None
) -> tuple[float, float] | None:
    """The threshold subtracted from the readings (n,) of a channel, and its uncertainty.

    Readings other than zero follow the standard's model and a step with their sign; predictions
    within the step are read as zero, and nothing else is.
    """
    known = motion.felt[:, channel] & np.isfinite(reading)
    zero = known & (np.abs(reading) <= ZERO * np.nanmax(np.abs(reading), initial=0.0))
    used = known & ~zero
    if zero.sum() < MIN_ZEROS or used.sum() < MIN_ZEROS:
        return None
    columns = regressors(motion, channel)
    design = np.column_stack([columns, np.sign(reading)])[used]
    covariance = inverse(design.T @ design)
    fitted = covariance @ (design.T @ reading[used])
    left = reading[used] - design @ fitted
    noise, threshold = float(np.std(left)), -float(fitted[-1])
    u = noise * float(np.sqrt(covariance[-1, -1]))
    step = 0.0 if quantiser is None else quantiser.step
    if threshold < max(CLEAR_THRESHOLD * u, MIN_CODES * step, noise):
        return None
    within = np.abs(columns @ fitted[:-1]) < threshold - np.minimum(noise, 0.5 * threshold)
    inside = known & within
    if inside.sum() < MIN_ZEROS or zero[inside].mean() < MIN_WITHIN:
        return None
    return threshold, np.sqrt(12.0) * u + step


def _within(predicted: np.ndarray, limit: float) -> bool:
    """Whether what reads zero is predicted to lie within a limit."""
    known = predicted[np.isfinite(predicted)]
    return len(known) >= MIN_ZEROS and bool(np.mean(np.abs(known) < limit) > MIN_WITHIN)


def _rests(motion: Motion) -> list[np.ndarray]:
    """The rows of each rest; by its later half a bias has been estimated."""
    rows = max(1, round(CALM / max(motion.interval, 1e-9)))
    mean = uniform_filter1d(np.nan_to_num(motion.rate), rows, axis=0)  # an encoder's noise is rough
    still = (np.linalg.norm(mean, axis=1) < STILL) & np.isfinite(motion.rate).all(axis=1)
    return [np.arange(a, b) for a, b in runs(still).tolist() if b - a >= MIN_REST]


def _zeroed(
    reading: np.ndarray, rests: Sequence[np.ndarray], quantiser: Quantiser | None, soon: int
) -> bool:
    """Whether the bias of each rest is subtracted: present in its first `soon` rows and then gone.

    Or the means of rests are closer to zero than their noise permits.
    """
    parts = [reading[rows] for rows in rests if np.isfinite(reading[rows]).all()]
    if len(parts) < MIN_RESTS:
        return False
    rough = np.concatenate([np.diff(part, 2) for part in parts])
    noise = float(np.std(rough)) / np.sqrt(6.0)
    if noise <= (0.0 if quantiser is None else DITHERED * quantiser.step):
        return False
    early = np.array([np.sqrt(soon) * part[:soon].mean() for part in parts]) / noise
    late = [part[len(part) // 2 :] for part in parts]
    late = np.array([np.sqrt(len(part)) * part.mean() for part in late]) / noise
    if chi2.cdf(float(late @ late), len(parts)) < SIGNIFICANT:
        return True
    gone = np.median(late**2) < GONE and np.median(np.abs(early)) > LASTING * np.median(
        np.abs(late)
    )
    calm = np.median([part[:soon].std() for part in parts]) < RINGING * noise
    return bool(gone and calm and chi2.sf(float(early @ early), len(parts)) < SIGNIFICANT)


def _deviation(values: np.ndarray) -> float:
    """Standard deviation of the known values; NaN of fewer than two."""
    known = values[np.isfinite(values)]
    return float(known.std()) if len(known) > 1 else np.nan
