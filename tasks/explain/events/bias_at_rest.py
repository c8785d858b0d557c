"""Gyro bias that the firmware estimates whenever it takes the unit to be at rest, and subtracts.

While no gyro has left ± `quiet` for `wait` seconds, an estimate b follows the readings r with the
time constant τ; what is written is y = r − b. So db/dt = y/τ there, and b is 1/τ times the
integral of what was written in those rows: a regressor that the recording itself holds, noise
included. A slow motion within ± `quiet` is taken for bias, and stays in all later readings.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import GYROS
from tasks.explain.events.event import Event, channel_names
from tasks.explain.events.noise import noise_by_rate
from tasks.model.fit import plain_prediction
from tasks.model.terms.standard import regressors
from tasks.motion.lag import first_order_lag
from tasks.motion.samples import in_blocks
from tasks.motion.whole import Motion
from tasks.words import message

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
CLEAR = 10.0  # standard deviations
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
    if best.gain < CLEAR**2 or best.rate * LONGEST < 1.0:
        return None
    if fit.rested(best.quiet, best.wait).sum() * fit.interval * best.rate < FOLLOWED:
        return None
    dispersion = fit.dispersion(best)
    telling = best.information > TELLING * best.information[-2:].sum()
    off = np.abs(best.rates - best.rate)[telling]
    u = np.sqrt(dispersion / best.information[telling])
    alike = (off < np.maximum(APART * u, ALIKE * best.rate)).all()
    if best.gain < CLEAR**2 * dispersion or not alike:
        return None
    return _event(fit, best, dispersion)


def _best(fit: "_Whitened") -> _Follows:
    """The `quiet` and `wait` that explain most; none is refined where none explains anything."""
    tried = [fit.follows(*one) for one in product(QUIETS, WAITS)]
    first = sorted(tried, key=lambda one: -one.gain)[:STARTS]
    refined = []
    for best in first if first[0].gain > CLEAR else ():
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
