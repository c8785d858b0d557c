"""Fits a list of terms to the rows of a recording, weighted by their white noise.

The covariance is the sandwich N⁻¹·(ΦᵀW Σ WΦ)·N⁻¹ with the whole noise Σ, drift included, so that
it holds for samples that are not independent.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.base import Unusable
from tasks.model.gauss_newton import Step, gauss_newton
from tasks.model.model import Model
from tasks.model.noise import RowNoise
from tasks.model.parameters import ACCEL_FIRST
from tasks.model.regression import WhitenedEquations, determined, inverse, of_channel
from tasks.model.simulate import CHANNEL_COUNT
from tasks.model.term import Column, Parameter, Term, parameters_of
from tasks.model.terms.standard import regressors
from tasks.motion.whole import Motion

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
