"""Peer 4: a Gaussian process for what the model leaves (Kennedy & O'Hagan, J. R. Stat. Soc. B 63,
2001), over rate, direction of gravity, time and temperature.

y = standard's columns · parameters + δ(inputs) + noise, in modules: the parameters by least
squares first, then δ on what they leave (Liu, Bayarri & Berger, Bayesian Anal. 4, 2009); fitted at
once, δ and the parameters cancel each other at the points and part between them. Length scales
are found by the marginal likelihood. Noise is known from the Allan variance (flicker as a sum of
relaxations), so that δ need not explain it. Points are means over each dwell, where attitude
turns in sectors of the turn. What is seen is told by the ratio of likelihoods; where, by the
length scales (automatic relevance).
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, Kernel

from tasks.explain.evidence.cells import FOLDS
from tests.proof.peers.observation import CHANNELS, Observation
from tests.proof.peers.peer import UNNAMED, Answer, HeldOut, Located
from tests.proof.peers.points import Points, inputs_of, points_of

THRESHOLD = 4.0  # twice the logarithm of the ratio of likelihoods, of the best channel
ITERATIONS = 25
LENGTHS = (0.05, 50.0)  # of an input's range
SIZES = (1e-2, 1e6)  # variance of δ in that of a mean


class Known(Kernel):
    """Covariance of the points that is known: the noise's."""

    def __init__(self, matrix: np.ndarray) -> None:
        self.matrix = matrix

    def __call__(self, X: np.ndarray, Y: Any = None, eval_gradient: bool = False) -> Any:
        if eval_gradient:
            return self.matrix, np.empty((*self.matrix.shape, 0))
        return self.matrix

    def diag(self, X: np.ndarray) -> np.ndarray:
        return np.diag(self.matrix).copy()

    def is_stationary(self) -> bool:
        return False


@dataclass(frozen=True)
class Fitted:
    """One channel. ratio: 2·ln of the ratio of likelihoods with and without δ; unit: in which the
    readings are counted; lengths: of each input, by its range; weights: of the points."""

    points: Points
    ratio: float
    unit: float
    known: np.ndarray
    readings: np.ndarray
    discrepancy: Kernel
    weights: np.ndarray
    lengths: np.ndarray


def gp_discrepancy(observation: Observation) -> Answer:
    """Which channels need a discrepancy, over which inputs, and its mean."""
    points = points_of(observation)
    fits = {c: _fit(observation, points, c) for c in observation.used}
    statistic = max((each.ratio for each in fits.values()), default=0.0)
    over = {c: each for c, each in fits.items() if each.ratio > THRESHOLD}
    located = [_located(c, each) for c, each in over.items()]
    located.sort(key=lambda one: -one.strength)
    if not over:
        return Answer(statistic, THRESHOLD)
    found = observation.nominal.copy()
    inputs = inputs_of(observation)
    for c, each in over.items():
        found[:, c] += each.unit * (each.discrepancy(inputs, each.points.inputs) @ each.weights)
    held_out = _unseen(list(over.values()))
    return Answer(statistic, THRESHOLD, tuple(located), (UNNAMED,), found, held_out)


def _fit(observation: Observation, points: Points, channel: int) -> Fitted:
    whole = len(observation.observed.t) / observation.observed.rate
    noise = observation.noises[channel]
    covariance = np.diag(noise.white / (2.0 * points.seconds[:, channel]))
    unit = float(np.sqrt(np.median(np.diag(covariance))))
    known = (covariance + noise.flicker * points.relaxations(whole)) / unit**2
    readings = points.mean(observation.left[:, channel, None], channel)[:, 0] / unit
    dimensions = points.inputs.shape[1]
    kernel = Known(known) + ConstantKernel(1.0, SIZES) * RBF(np.ones(dimensions), LENGTHS)
    process = GaussianProcessRegressor(kernel, alpha=1e-10, optimizer=_climb)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a length scale at its bound: an input of no relevance
        process.fit(points.inputs, readings)
    plain = _likelihood(known, readings)
    best = process.kernel_
    return Fitted(
        points, 2.0 * (process.log_marginal_likelihood_value_ - plain), unit, known, readings,
        best.k2, np.ravel(process.alpha_), np.atleast_1d(best.k2.k2.length_scale),
    )  # fmt: skip


def _climb(
    objective: Callable[..., Any], start: np.ndarray, bounds: np.ndarray
) -> tuple[np.ndarray, float]:
    found = minimize(
        objective, start, jac=True, bounds=bounds, method="L-BFGS-B",
        options={"maxiter": ITERATIONS},
    )  # fmt: skip
    return found.x, found.fun


def _likelihood(covariance: np.ndarray, readings: np.ndarray) -> float:
    factor = np.linalg.cholesky(covariance)
    white = np.linalg.solve(factor, readings)
    constant = len(readings) * np.log(2.0 * np.pi)
    return float(-0.5 * (white @ white + constant) - np.log(np.diag(factor)).sum())


def _located(channel: int, fitted: Fitted) -> Located:
    """By the input over whose spread δ changes most."""
    spread = fitted.points.inputs.std(axis=0) / fitted.lengths
    most = int(np.argmax(spread))
    name = fitted.points.names[most]
    dimension = {"ω": "rate", "u": "attitude", "t": "time", "T": "temperature"}[name[0]]
    words = f"{name}: length scale {fitted.lengths[most]:.2g} of its range"
    return Located(CHANNELS[channel], dimension, words, fitted.ratio)  # type: ignore[arg-type]


def _unseen(fits: list[Fitted]) -> HeldOut:
    """Points of each fold as the others predict them, without and with δ, at the same lengths."""
    before = after = gain = 0.0
    for each in fits:
        whole = each.known + each.discrepancy(each.points.inputs)
        for fold in range(FOLDS):
            mine = each.points.fold == fold
            if not mine.any() or mine.all():
                continue
            plain = _predictive(each.known, each.readings, mine)
            better = _predictive(whole, each.readings, mine)
            before, after = before + plain[0], after + better[0]
            gain += better[1] - plain[1]
    return HeldOut(float(np.sqrt(after / before)) if before > 0 else 1.0, gain)


def _predictive(
    covariance: np.ndarray, readings: np.ndarray, mine: np.ndarray
) -> tuple[float, float]:
    """Squared misfit of some points predicted from the others, and their log-likelihood."""
    others = ~mine
    link = np.linalg.solve(covariance[np.ix_(others, others)], covariance[np.ix_(others, mine)])
    left = readings[mine] - link.T @ readings[others]
    spread = covariance[np.ix_(mine, mine)] - covariance[np.ix_(mine, others)] @ link
    _, size = np.linalg.slogdet(spread)
    square = float(left @ np.linalg.solve(spread, left))
    return float(left @ left), -0.5 * (square + float(size))
