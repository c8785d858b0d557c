"""A list of terms fitted to a recording's rows: weighted least squares, Gauss and Newton.

Linear parameters are solved by the normal equations, those of the input by iterating. The
weights follow the white noise; the covariance is the sandwich N⁻¹·(ΦᵀW Σ WΦ)·N⁻¹ with the whole
noise Σ, drift included, so that it holds for samples that are not independent.
"""

from dataclasses import dataclass

import numpy as np

from schemas.base import Unusable
from tasks.model.noise import RowNoise
from tasks.model.simulate import CHANNEL_COUNT, Design, linearise, predict
from tasks.model.term import Parameter, Term, nominal_values, parameters_of
from tasks.motion.whole import Motion

MOST_STEPS = 30
SMALL_STEP = 1e-9  # of a parameter's plausible range: converged
RANK = 1e-11  # of the largest eigenvalue of the scaled normal matrix


@dataclass(frozen=True)
class Fit:
    """What a fit found, SI throughout.

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
    """Fit a list of terms to readings (n, 6) in rad/s and m/s².

    Readings that are NaN and rows whose motion a channel's terms do not know are not used.
    start: (p,) first values, those of an ideal unit unless given.
    Raises Unusable where the iteration does not come to rest.
    """
    values = nominal_values(terms) if start is None else start.astype(float)
    ranges = np.array([high - low for low, high in (p.plausible for p in parameters_of(terms))])
    for _ in range(MOST_STEPS):
        equations = _Equations.of(linearise(terms, motion, values), readings, noise)
        inverse, estimable = _inverse(equations.normal)
        step = inverse @ equations.right
        values = values + step
        if (np.abs(step) <= SMALL_STEP * ranges).all():
            break
    else:
        names = ", ".join(term.name for term in terms)
        raise Unusable(
            f"the fit of {names} did not settle in {MOST_STEPS} steps; the recording does not "
            "determine these terms together: leave one out"
        )
    return _finished(terms, motion, readings, noise, values, equations, inverse, estimable)


@dataclass(frozen=True)
class _Equations:
    """Normal equations at some values: normal (p, p), right (p,), weights (n, 6), 0: not used."""

    design: Design
    normal: np.ndarray
    right: np.ndarray
    weights: np.ndarray

    @classmethod
    def of(cls, design: Design, readings: np.ndarray, noise: RowNoise) -> "_Equations":
        count = len(design.columns)
        normal, right = np.zeros((count, count)), np.zeros(count)
        weights = np.zeros_like(readings)
        for channel in range(CHANNEL_COUNT):
            which, columns = design.of_channel(channel)
            used = np.isfinite(readings[:, channel]) & (noise.white[:, channel] > 0)
            used &= np.isfinite(columns).all(axis=1)
            if not which or not used.any():
                continue
            weights[used, channel] = 1.0 / noise.white[used, channel]
            miss = np.where(used, readings[:, channel] - design.prediction[:, channel], 0.0)
            weighted = _weighted(columns, weights[:, channel])
            normal[np.ix_(which, which)] += _weighted(columns, used).T @ weighted
            right[which] += weighted.T @ miss
        return cls(design, normal, right, weights)

    def spread(self, noise: RowNoise) -> np.ndarray:
        """Covariance (p, p) of the right side, ΦᵀW Σ WΦ, by the whole noise."""
        spread = np.zeros_like(self.normal)
        for channel in np.flatnonzero(self.weights.any(axis=0)):
            which, columns = self.design.of_channel(int(channel))
            weighted = _weighted(columns, self.weights[:, channel])
            spread[np.ix_(which, which)] += noise.gram(int(channel), weighted)
        return spread


def _weighted(columns: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Columns (n, k) times weights (n,); zero where the weight is, whatever the column says."""
    return np.where((weights > 0)[:, None], columns, 0.0) * weights[:, None]


def _inverse(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Generalised inverse (p, p) of the normal matrix and which parameters it determines."""
    scale = np.sqrt(np.diag(normal))
    scale[scale == 0] = 1.0
    scaled = normal / np.outer(scale, scale)
    inverse = np.linalg.pinv(scaled, rcond=RANK, hermitian=True)
    resolution = np.diag(inverse @ scaled)
    return inverse / np.outer(scale, scale), np.abs(resolution - 1.0) < 1e-6


def _finished(
    terms: tuple[Term, ...],
    motion: Motion,
    readings: np.ndarray,
    noise: RowNoise,
    values: np.ndarray,
    equations: _Equations,
    inverse: np.ndarray,
    estimable: np.ndarray,
) -> Fit:
    miss = readings - predict(terms, motion, values)
    used = equations.weights > 0
    square = np.where(used, miss**2 * equations.weights, 0.0)
    return Fit(
        terms=terms,
        values=np.where(estimable, values, np.nan),
        estimable=estimable,
        covariance=inverse @ equations.spread(noise) @ inverse,
        residuals=np.where(used, miss, np.nan),
        chi2=float(square.sum()),
        degrees=int(used.sum()) - int(np.linalg.matrix_rank(inverse, hermitian=True)),
    )
