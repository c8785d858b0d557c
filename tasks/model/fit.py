"""Fits a list of terms to the rows of a recording, weighted by their white noise.

The covariance is the sandwich N⁻¹·(ΦᵀW Σ WΦ)·N⁻¹ with the whole noise Σ, drift included, so that
it holds for samples that are not independent.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from schemas.base import Unusable
from tasks.model.model import CHANNEL_COUNT, Model
from tasks.model.noise import RowNoise
from tasks.model.term import ACCEL_FIRST, Column, Parameter, Term, parameters_of
from tasks.model.terms.standard import regressors
from tasks.motion.whole import Motion

# Whitened normal equations of a linearised model, as every fit of a list of terms solves them.
#
# Whoever knows the noise whitens: by the variance of each row (`tasks.model.fit`), in the
# transformed domain (`tasks.explain.noise`). From there on all fits are the same algebra.

RANK = 1e-9  # of the largest eigenvalue of the scaled normal matrix: smaller ones are rounding
RESOLVED = 1e-6  # a parameter is determined where its resolution is one within this


@dataclass(frozen=True)
class WhitenedEquations:
    """A model linearised at its values, whitened.

    grams: for each of six channels the products (k + 1, k + 1) of its whitened columns and, last,
    of its misfit, reading minus prediction. which: (k,) for each channel, which of the `count`
    columns it has.
    """

    grams: tuple[np.ndarray, ...]
    which: tuple[np.ndarray, ...]
    count: int

    def normal(self) -> tuple[np.ndarray, np.ndarray, float]:
        """Normal matrix (q, q), right side (q,) and chi-squared over all channels."""
        normal, right, misfit = np.zeros((self.count, self.count)), np.zeros(self.count), 0.0
        for gram, which in zip(self.grams, self.which, strict=True):
            normal[np.ix_(which, which)] += gram[:-1, :-1]
            right[which] += gram[:-1, -1]
            misfit += float(gram[-1, -1])
        return normal, right, misfit


def of_channel(
    columns: Sequence[Column], misfit: np.ndarray, channel: int
) -> tuple[np.ndarray, list[np.ndarray]]:
    """Which columns (k,) a channel has; these and, last, its misfit of (n, 6), each (n,)."""
    which = [q for q, column in enumerate(columns) if channel in column]
    return np.array(which, int), [*(columns[q][channel] for q in which), misfit[:, channel]]


Whiten = Callable[[Sequence[Column], np.ndarray], WhitenedEquations]
"""Columns and misfit (n, 6) of a model -> its normal equations, by what is known of the noise."""

Scores = Callable[[Sequence[Column], np.ndarray], tuple[np.ndarray, float]]
"""The same -> their right side (q,) and chi-squared alone, without products of columns."""


def inverse(normal: np.ndarray) -> np.ndarray:
    """Generalised inverse of a symmetric matrix (p, p), scaled to a unit diagonal first."""
    scale = np.sqrt(np.maximum(np.diag(normal), 0.0))
    scale = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0)
    values, vectors = np.linalg.eigh(normal * scale[:, None] * scale)
    kept = values > RANK * max(float(values[-1]), 0.0) if len(values) else np.zeros(0, bool)
    turned = vectors[:, kept]
    return np.asarray((turned / values[kept]) @ turned.T * scale[:, None] * scale)


def determined(normal: np.ndarray, solution: np.ndarray) -> np.ndarray:
    """(p,) bool: parameters that the equations determine, by their generalised inverse (p, p)."""
    return np.asarray(np.abs(np.diag(solution @ normal) - 1.0) < RESOLVED)


# Gauss-Newton iteration for any list of terms and any noise model.
#
# It is our own, and no optimiser of a library, for three reasons. A step ends where it no longer
# matters beside the standard uncertainty, which a library that knows no covariance cannot tell:
# `scipy.optimize.least_squares` goes on to the last digit, at four to six linearisations of a
# whole recording more; and between two linearisations steps go on with the same columns, each at
# the cost of one prediction, as long as chi-squared falls (chord method; Kelley, Iterative
# Methods for Linear and Nonlinear Equations, SIAM 1995, 5.4.1). A continuous shape (a time
# constant) is differentiated by the model only where its term has a size at all, so that the
# number of columns changes on the way. And a parameter that would become negative where no unit
# has it so (a time constant, a filter's corner) is held at zero, where the others' step is solved
# again. Fits without terms (`gravity_fit`, `moves` of the joint method) use scipy's.

MAX_CHORDS = 4  # steps with the same columns: of more the columns are too old


@dataclass(frozen=True)
class Step:
    """A step (q,) of the free parameters, then the shapes.

    covariance: (q, q) as white noise has it. gain: chi-squared that the step promises.
    misfit: chi-squared from where it sets out, what is known beforehand included.
    columns: by which the parameters were linearised.
    """

    change: np.ndarray
    covariance: np.ndarray
    gain: float
    misfit: float
    columns: Sequence[Column]

    @property
    def u(self) -> np.ndarray:
        """(q,) standard uncertainties."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def _step(model: Model, motion: Motion, readings: np.ndarray, whiten: Whiten) -> Step:
    """The step from where a model stands; readings: (n, 6) rad/s and m/s²."""
    design = model.design(motion)
    normal, right, chi2 = whiten(design.columns, readings - design.prediction).normal()
    prior = _prior(model, len(normal))
    covariance = inverse(normal + np.diag(prior))
    return _promised(model, design.columns, covariance, right, chi2)


def _chord(
    model: Model, before: Step, motion: Motion, readings: np.ndarray, scores: Scores
) -> Step:
    """A step from the present model with the columns and the covariance of an earlier one."""
    right, chi2 = scores(before.columns, readings - model.prediction(motion))
    return _promised(model, before.columns, before.covariance, right, chi2)


def _promised(
    model: Model, columns: Sequence[Column], covariance: np.ndarray, right: np.ndarray, chi2: float
) -> Step:
    """What a right side (q,) promises, beside what is known of the parameters beforehand."""
    values, prior = model.values[model.free], _prior(model, len(right))
    pull = right.copy()
    pull[: len(values)] -= prior[: len(values)] * values
    change = covariance @ pull
    chi2 += float(prior[: len(values)] @ values**2)
    return Step(change, covariance, float(change @ pull), chi2, columns)


def _prior(model: Model, count: int) -> np.ndarray:
    """(count,) precision beforehand of the free parameters; of the shapes none."""
    prior = np.zeros(count)
    known = model.prior[model.free]
    prior[: len(known)] = known
    return prior


def gauss_newton(
    model: Model,
    motion: Motion,
    readings: np.ndarray,
    whiten: Whiten,
    settled: Callable[[Model, Step], bool],
    max_steps: int,
    scores: Scores | None = None,
) -> tuple[Model, bool]:
    """The model with its free parameters and continuous shapes fitted, and whether it settled.

    max_steps: linearisations. scores: by which steps go on between them, and are shortened where
    they overshoot; without, every step is taken whole.
    """
    for _ in range(max_steps):
        model, end = _iterated(model, motion, readings, whiten, settled, scores)
        if end is not None:
            return model, end
    return model, False


def _iterated(
    model: Model,
    motion: Motion,
    readings: np.ndarray,
    whiten: Whiten,
    settled: Callable[[Model, Step], bool],
    scores: Scores | None,
) -> tuple[Model, bool | None]:
    """The model after one linearisation, and whether it settled; None if it has to continue.

    The columns, which are large, are released on return: those of the next never coexist with them.
    """
    step = _step(model, motion, readings, whiten)
    stepped = model.stepped(step.change, step.covariance)
    if stepped.negative.any():  # the others' step made up for it: they are solved again
        return model.held_at_zero(stepped.negative), None
    if settled(stepped, step):
        return stepped, True
    if scores is None:
        return stepped, None
    model, fell = _by_chords(model, step, motion, readings, settled, scores)
    if settled(model, replace(step, gain=fell)):  # no step keeps what it promises
        return model, False
    return model, None


def _by_chords(
    model: Model,
    step: Step,
    motion: Motion,
    readings: np.ndarray,
    settled: Callable[[Model, Step], bool],
    scores: Scores,
) -> tuple[Model, float]:
    """The model after a step and others with its columns, and by how much chi-squared fell.

    A step that makes it worse is halved.
    """
    start, least = step.misfit, step.misfit
    model = model.stepped(0.0 * step.change, step.covariance)
    for _ in range(MAX_CHORDS):
        stepped = model.stepped(step.change, step.covariance)
        if stepped.negative.any():
            break
        if len(stepped.fitted_shapes) != len(model.fitted_shapes):
            return stepped, np.inf  # a shape that can be followed only from now on
        ahead = _chord(stepped, step, motion, readings, scores)
        if ahead.misfit >= least:
            step = replace(step, change=0.5 * step.change)
            continue
        model, least, step = stepped, ahead.misfit, ahead
        if settled(model, step):
            break
    return model, start - least


MAX_FIT_ROWS = 400_000  # evenly spread; more rows would not change a prediction by its noise
MAX_STEPS = 30
SMALL_STEP = 1e-9  # of a parameter's plausible range: converged


@dataclass(frozen=True)
class Fit:
    """The parameters of a list of terms, SI throughout.

    values, u: (p,), NaN where the rows do not determine a parameter; covariance: (p, p).
    residuals: (n, 6) reading minus prediction, NaN where a row was not used.
    chi2: Σ residual²/white variance, on `degrees` degrees of freedom.
    """

    terms: tuple[Term, ...]
    values: np.ndarray
    estimable: np.ndarray
    covariance: np.ndarray
    residuals: np.ndarray
    chi2: float
    degrees: int

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return parameters_of(self.terms)

    @property
    def u(self) -> np.ndarray:
        variance = np.maximum(np.diag(self.covariance), 0.0)
        return np.where(self.estimable, np.sqrt(variance), np.nan)


def fit(
    terms: tuple[Term, ...],
    motion: Motion,
    readings: np.ndarray,
    noise: RowNoise,
    start: np.ndarray | None = None,
) -> Fit:
    """Fit a list of terms and their continuous shapes to readings (n, 6) in rad/s and m/s².

    Readings that are NaN and rows whose motion a channel's terms do not know are not used.
    start: (p,) first values, those of an ideal unit unless given.
    Raises Unusable where the iteration does not converge.
    """
    ranges = np.array([high - low for low, high in (p.plausible for p in parameters_of(terms))])

    def settled(model: Model, step: Step) -> bool:
        small = SMALL_STEP * ranges[model.free]
        return bool((np.abs(step.change[: len(small)]) <= small).all())

    def whiten(columns: Sequence[Column], misfit: np.ndarray) -> WhitenedEquations:
        return _whitened(columns, misfit, noise)

    model = Model.of(terms, None if start is None else start.astype(float))
    model, converged = gauss_newton(model, motion, readings, whiten, settled, MAX_STEPS)
    if not converged:
        names = ", ".join(term.name for term in terms)
        raise Unusable(
            f"the fit of {names} did not settle in {MAX_STEPS} steps; the recording does not "
            "determine these terms together: leave one out"
        )
    return _finished(model, motion, readings, noise)


def _whitened(columns: Sequence[Column], misfit: np.ndarray, noise: RowNoise) -> WhitenedEquations:
    grams, which = [], []
    for channel in range(CHANNEL_COUNT):
        own, signals = of_channel(columns, misfit, channel)
        stack = np.column_stack(signals)
        used = _used(stack, noise.white[:, channel])
        white = np.where(used, noise.white[:, channel], 1.0)
        stack = np.where(used[:, None], stack, 0.0) / np.sqrt(white)[:, None]
        grams.append(stack.T @ stack)
        which.append(own)
    return WhitenedEquations(tuple(grams), tuple(which), len(columns))


def _used(stack: np.ndarray, white: np.ndarray) -> np.ndarray:
    """(n,) bool: rows of columns and misfit (n, k + 1) that a channel's fit uses."""
    return np.asarray(np.isfinite(stack).all(axis=1) & (white > 0) & (stack.shape[1] > 1))


def _finished(model: Model, motion: Motion, readings: np.ndarray, noise: RowNoise) -> Fit:
    design = model.design(motion)
    misfit = readings - design.prediction
    normal, _, _ = _whitened(design.columns, misfit, noise).normal()
    solution, spread = inverse(normal), np.zeros_like(normal)
    used = np.zeros(readings.shape, bool)
    for channel in range(CHANNEL_COUNT):
        which, signals = of_channel(design.columns, misfit, channel)
        stack = np.column_stack(signals)
        used[:, channel] = _used(stack, noise.white[:, channel])
        if not used[:, channel].any():
            continue
        weights = np.where(used[:, channel], 1.0 / noise.white[:, channel], 0.0)
        weighted = np.where(used[:, channel, None], stack[:, :-1], 0.0) * weights[:, None]
        spread[np.ix_(which, which)] += noise.gram(channel, weighted)
    rows = np.flatnonzero(model.free)
    inner = np.ix_(rows, rows)
    covariance, estimable = np.zeros_like(model.covariance), np.zeros(len(model.values), bool)
    covariance[inner] = (solution @ spread @ solution)[: len(rows), : len(rows)]
    estimable[rows] = determined(normal, solution)[: len(rows)]
    return Fit(
        terms=model.terms,
        values=np.where(estimable, model.values, np.nan),
        estimable=estimable,
        covariance=covariance,
        residuals=np.where(used, misfit, np.nan),
        chi2=float(np.where(used, misfit**2 / noise.white, 0.0).sum()),
        degrees=int(used.sum()) - round(float(np.trace(solution @ normal))),
    )


# The standard's model fitted to whole samples by ordinary least squares, channel by channel.
#
# Every sample counts the same. It is the prediction that events and sample noise are read off
# before anything is known of the noise; `tasks.model.fit` weights by the noise.


def plain_prediction(
    readings: np.ndarray,
    motion: Motion,
    masked: np.ndarray | None = None,
    *,
    own_squared_rate: bool = False,
) -> np.ndarray:
    """What the standard's model predicts (n, 6), fitted to the readings (n, 6) rad/s, m/s².

    masked: (n, 6) bool, readings that the fit does not use; nor does it use NaN. The prediction is
    NaN where the motion is not known, and in a channel without a reading to fit. own_squared_rate:
    an accelerometer follows ω² of its own axis, too, which the standard leaves out; noise that is
    read off the residual then holds none of it.
    """
    predicted = np.full(readings.shape, np.nan)
    rows = slice(None, None, len(readings) // MAX_FIT_ROWS + 1)
    for channel in range(CHANNEL_COUNT):
        used = motion.felt[rows, channel] & np.isfinite(readings[rows, channel])
        if masked is not None:
            used &= ~masked[rows, channel]
        if not used.any():
            continue
        columns = regressors(motion, channel)
        if own_squared_rate and channel >= ACCEL_FIRST:
            columns = np.column_stack([columns, motion.rate[:, channel - ACCEL_FIRST] ** 2])
        design = columns[rows][used]
        right = design.T @ readings[rows, channel][used]
        fitted = columns @ (inverse(design.T @ design) @ right)
        predicted[:, channel] = np.where(motion.felt[:, channel], fitted, np.nan)
    return predicted
