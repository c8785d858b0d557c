"""Has four peers answer a recording in a process that knows nothing of the truth.

Needs the extra `peers` (`tests.proof.peers.score` says whether it is there).
"""

import json
import re
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from pysindy import STLSQ
from scipy.optimize import minimize
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, Kernel

from schemas.discrepancy import Dimension
from schemas.recording import Recording
from tasks.explain.evidence.cells import DIFFUSE, FOLDS
from tests.proof.peers.observation import (
    BLOCK_RATE,
    CHANNELS,
    SAME,
    UNNAMED,
    Answer,
    Equations,
    HeldOut,
    Located,
    Observation,
    Points,
    in_order,
    inputs_of,
    points_of,
    see,
)

# What a chosen regressor means, where it has one fair reading in the catalogue; else nothing.
#
# Left out with reason: a gyro that follows its own angular acceleration (a delay, a low-pass and
# an angular acceleration do), anything that follows plain time (a walk, a step and a warm-up do),
# cross products of forces in an accelerometer, and what the catalogue has no name for (humidity).

AXES = "xyz"
OWN, OTHER = "i", "j"

GYRO = {
    "ω_i²": "gyro_scale_nonlinearity",
    "ω_i³": "gyro_scale_nonlinearity",
    "|ω_i|": "gyro_scale_asymmetry",
    "u_i²": "gyro_g2_sensitivity",
    "u_j²": "gyro_g2_sensitivity",
    "u_i·u_j": "gyro_g2_sensitivity",
    "u_j·u_j": "gyro_g2_sensitivity",
    "ω_i·u_i": "gyro_scale_g_dependence",
    "ω_i·u_j": "gyro_scale_g_dependence",
    "ω_i·T": "temperature_scale",
    "α_j": "gyro_angular_acceleration",
    "n_i": "earth_rotation",
    "n_j": "magnetic_sensitivity",
}
ACCEL = {
    "u_i²": "accel_nonlinearity",
    "u_i³": "accel_nonlinearity",
    "u_i·T": "temperature_scale",
    "ω_i·ω_j": "lever_arm",
    "α_j": "lever_arm",
    "vibration": "vibration_rectification",
}
EITHER = {
    "T": "temperature_bias",
    "Ṫ": "thermal_gradient",
    "V": "supply_sensitivity",
    **{f"exp(-t/{tau})": "thermal_transient" for tau in (60, 300, 900)},
}

FOLLOWED: dict[str, Dimension] = {
    "T|Ṫ": "temperature",
    "α": "ramps",
    "ω": "rate",
    "V|H|p|vibration": "recorded",
    "u|n": "attitude",
}


def reading_of(channel: int, regressor: str) -> str | None:
    """The catalogue name that a regressor in a channel (0 to 5) stands for; None: no fair one."""
    own = AXES[channel % 3]
    form = re.sub(r"_([xyz])", lambda m: f"_{OWN if m[1] == own else OTHER}", regressor)
    ordered = [form, "·".join(reversed(form.split("·")))]
    table = EITHER | (GYRO if channel < 3 else ACCEL)
    return next((table[one] for one in ordered if one in table), None)


def dimension_of(regressor: str) -> Dimension:
    """What of the run a regressor follows."""
    for letters, dimension in FOLLOWED.items():
        if any(re.match(rf"\|?({letters})(_|²|³|\||$)", part) for part in regressor.split("·")):
            return dimension
    return "time"


# Algebra on normal equations that the regressions share: the standard's columns taken out first
# (Frisch, Waugh and Lovell), fits, and what a fit is worth on segments that it did not see.


def partialled_out(gram: np.ndarray, base: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gram (p, p) of the library without the standard's part, right side (p,), and which columns
    are more than what the standard tells."""
    shared = gram[:base, base:]
    rest = gram[base:, base:] - shared.T @ _solved(gram[:base, :base], shared)
    observation = np.diag(rest)[:-1] > SAME * np.diag(gram)[base:-1]
    return rest[:-1, :-1], rest[:-1, -1], observation


def fit(gram: np.ndarray, base: int, chosen: Sequence[int]) -> np.ndarray:
    """(m − 1,) coefficients of the standard's columns and the chosen ones; 0 elsewhere."""
    which = [*range(base), *(base + k for k in chosen)]
    values = np.zeros(len(gram) - 1)
    values[which] = _solved(gram[np.ix_(which, which)], gram[which, -1])
    return values


def _solved(normal: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Least squares of a normal matrix that may be short of rank: axes that never turned."""
    size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    scaled = np.linalg.pinv(normal / size[:, None] / size, rcond=1e-11, hermitian=True)
    if right.ndim == 1:
        return np.asarray(scaled @ (right / size) / size)
    return np.asarray(scaled @ (right / size[:, None]) / size[:, None])


def surprise(equations: Equations, fold: int, chosen: Sequence[int]) -> tuple[float, float]:
    """What a fold is beside a fit to the others: squared misfit, and −2·ln of its likelihood.

    With e the error of prediction and C the covariance of what is fitted, eᵀ(1 + J·C·Jᵀ)⁻¹e is by
    how much the squared misfit grows when the fold is fitted, too, and |1 + J·C·Jᵀ| the ratio of
    the determinants of the normal matrices (recursive least squares).
    """
    which = [*range(equations.base), *(equations.base + k for k in chosen)]
    whole = equations.without(None)
    size = np.sqrt(np.maximum(np.diag(whole)[which], 1e-300))
    square = likelihood = 0.0
    for gram, sign in ((whole, 1.0), (equations.without(fold), -1.0)):
        normal = gram[np.ix_(which, which)] / size[:, None] / size + DIFFUSE * np.eye(len(which))
        right = gram[which, -1] / size
        square += sign * float(gram[-1, -1] - right @ np.linalg.solve(normal, right))
        likelihood += sign * float(np.linalg.slogdet(normal)[1])
    return square, square + likelihood


def unseen(equations: Sequence[Equations | None], chosen: Sequence[Sequence[int]]) -> HeldOut:
    """What the chosen columns of each channel are worth on folds that the fit did not see."""
    before, after, gain = 0.0, 0.0, 0.0
    for each, mine in zip(equations, chosen, strict=True):
        if each is None or not mine:
            continue
        for fold in range(FOLDS):
            plain, better = surprise(each, fold, ()), surprise(each, fold, mine)
            before, after = before + plain[0], after + better[0]
            gain += 0.5 * (plain[1] - better[1])
    return HeldOut(float(np.sqrt(after / before)) if before > 0.0 else 1.0, gain)


def predicted(observation: Observation, chosen: Sequence[Sequence[int]]) -> np.ndarray:
    """(n, 6) the standard's model with the chosen columns of each channel, fitted together."""
    found = observation.nominal.copy()
    for c, mine in enumerate(chosen):
        equations = observation.equations[c]
        if equations is None or not mine:
            continue
        values = fit(equations.without(None), equations.base, mine) / equations.scale
        found[:, c] += observation.standard[c] @ values[: equations.base]
        for k in mine:
            found[:, c] += values[equations.base + k] * observation.library[equations.names[k]]
    return found


# Peer 1: means of the residuals, segment by segment, against what noise makes of them.
#
# The standard's model is fitted by least squares. A segment whose mean residual is beyond so many
# standard deviations of its noise (Allan variance: angle random walk and bias instability) is
# told. It names nothing and models nothing.

RESIDUAL_THRESHOLD = 3.7  # standard deviations
FEWEST = 5  # blocks of a segment


def residual_threshold(observation: Observation) -> Answer:
    """Which segments of which channels are off."""
    beyond = deviations(observation)
    statistic = float(np.nanmax(beyond, initial=0.0))
    located = []
    for c in observation.used:
        over = np.flatnonzero(beyond[:, c] > RESIDUAL_THRESHOLD)
        if len(over):
            names = tuple(observation.observed.segments[k].name for k in over)
            strength = float(beyond[over, c].max())
            words = f"{len(over)} segment means beyond {RESIDUAL_THRESHOLD:g} standard deviations"
            located.append(Located(CHANNELS[c], "level", words, strength, names))
    located.sort(key=lambda one: -one.strength)
    return Answer(statistic, RESIDUAL_THRESHOLD, tuple(located), (UNNAMED,) if located else ())


def deviations(observation: Observation) -> np.ndarray:
    """(segments, 6) |mean residual| in standard deviations; NaN where there is none."""
    observed = observation.observed
    whole = len(observed.t) / observed.rate
    found = np.full((len(observed.segments), 6), np.nan)
    for number in range(len(observed.segments)):
        rows = observed.segment == number
        for c in observation.used:
            weight = observed.weight[rows, c] ** 2
            if (weight > 0).sum() < FEWEST:
                continue
            mean = float(weight @ observation.left[rows, c] / weight.sum())
            seconds = np.array([weight.sum() / observed.rate])
            found[number, c] = abs(mean) / np.sqrt(observation.noises[c].of_mean(seconds, whole)[0])
    return found


# Peer 4: a Gaussian process for what the model leaves (Kennedy & O'Hagan, J. R. Stat. Soc. B 63,
# 2001), over rate, direction of gravity, time and temperature.
#
# y = standard's columns · parameters + δ(inputs) + noise, in modules: the parameters by least
# squares first, then δ on what they leave (Liu, Bayarri & Berger, Bayesian Anal. 4, 2009); fitted
# at once, δ and the parameters cancel each other at the points and part between them. Length
# scales are found by the marginal likelihood. Noise is known from the Allan variance (flicker as
# a sum of relaxations), so that δ need not explain it. Points are means over each dwell, where
# attitude turns in sectors of the turn. What is seen is told by the ratio of likelihoods; where,
# by the length scales (automatic relevance).

GP_THRESHOLD = 4.0  # twice the logarithm of the ratio of likelihoods, of the best channel
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
    over = {c: each for c, each in fits.items() if each.ratio > GP_THRESHOLD}
    located = [_located(c, each) for c, each in over.items()]
    located.sort(key=lambda one: -one.strength)
    if not over:
        return Answer(statistic, GP_THRESHOLD)
    found = observation.nominal.copy()
    inputs = inputs_of(observation)
    for c, each in over.items():
        found[:, c] += each.unit * (each.discrepancy(inputs, each.points.inputs) @ each.weights)
    held_out = _unseen(list(over.values()))
    return Answer(statistic, GP_THRESHOLD, tuple(located), (UNNAMED,), found, held_out)


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


# Peer 3: sparse regression of what the standard leaves on a polynomial library (SINDy).
#
# pysindy's sequentially thresholded least squares (Brunton, Proctor & Kutz, PNAS 113, 2016), its
# threshold by cross validation on held-out segments. Columns are whitened, cleared of the
# standard's part and brought to unit size, so that a coefficient is in standard deviations of the
# noise; the Cholesky factor of their normal equations stands for the rows, with the same least
# squares.

SINDY_THRESHOLD = 3.0  # nats gained on held-out segments by the best channel
GRID = (4.0, 6.0, 10.0, 20.0, 50.0)  # standard deviations a coefficient must have
RIDGE = 0.01  # of a column's power
DEPENDENT = 1e-8  # of a column's power: rounding

Reduced = tuple[np.ndarray, np.ndarray, np.ndarray]


def sindy(observation: Observation) -> Answer:
    """What each channel's sparse model holds; named where its columns have one fair reading."""
    gains, names, located = [0.0], [], []
    which: list[list[int]] = []
    for c, each in enumerate(observation.equations):
        gain, mine = (0.0, []) if each is None else _best(each, observation)
        gains.append(gain)
        if each is None or gain <= SINDY_THRESHOLD:
            which.append([])
            continue
        which.append(mine)
        for k, size in zip(mine, _sizes(each, mine), strict=True):
            names.append((size**2, reading_of(c, each.names[k]) or UNNAMED))
            located.append(Located(CHANNELS[c], dimension_of(each.names[k]), each.names[k], size))
    located.sort(key=lambda one: -one.strength)
    found = predicted(observation, which) if names else None
    held_out = unseen(observation.equations, which)
    return Answer(max(gains), SINDY_THRESHOLD, tuple(located), in_order(names), found, held_out)


def _best(equations: Equations, observation: Observation) -> tuple[float, list[int]]:
    """Nats gained on held-out segments, and the columns, at the threshold where that is most."""
    allowed = [k for k, name in enumerate(equations.names) if name in observation.polynomial_names]
    gains = np.zeros(len(GRID))
    for fold in range(FOLDS):
        plain = surprise(equations, fold, ())[1]
        reduced = _reduced(equations.without(fold), equations.base, allowed)
        for n, threshold in enumerate(GRID):
            mine = _sparse(reduced, threshold)
            if mine:
                gains[n] += 0.5 * (plain - surprise(equations, fold, mine)[1])
    best = int(np.argmax(gains))
    whole = _reduced(equations.without(None), equations.base, allowed)
    return float(gains[best]), _sparse(whole, GRID[best])


def _reduced(gram: np.ndarray, base: int, allowed: Sequence[int]) -> Reduced:
    """Rows (r, k) and readings (r,) with the same least squares as all blocks; the columns."""
    normal, right, open_ = partialled_out(gram, base)
    mine = np.array([k for k in allowed if open_[k]], int)
    size = np.sqrt(np.diag(normal)[mine])
    power, turned = np.linalg.eigh(normal[np.ix_(mine, mine)] / size[:, None] / size)
    kept = power > DEPENDENT
    rows = np.sqrt(power[kept])[:, None] * turned[:, kept].T
    return rows, turned[:, kept].T @ (right[mine] / size) / np.sqrt(power[kept]), mine


def _sparse(reduced: Reduced, threshold: float) -> list[int]:
    """The columns that are left at one threshold."""
    rows, readings, mine = reduced
    if not len(mine):
        return []
    optimiser = STLSQ(threshold=threshold, alpha=RIDGE, unbias=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that a threshold leaves nothing is an answer
        optimiser.fit(rows, readings[:, None])
    return [int(k) for k in mine[np.flatnonzero(optimiser.coef_[0])]]


def _sizes(equations: Equations, mine: Sequence[int]) -> list[float]:
    """Each column's strength: its coefficient in standard deviations, all fitted together."""
    normal, right, _ = partialled_out(equations.without(None), equations.base)
    block = np.linalg.pinv(normal[np.ix_(mine, mine)], rcond=1e-11, hermitian=True)
    spread = np.sqrt(np.maximum(np.diag(block), 1e-300))
    return [float(size) for size in np.abs(block @ right[mine]) / spread]


# Peer 2: forward stepwise regression by BIC over the generic library, channel by channel.
#
# Noise has colour, so rows are whitened by the Allan variance first; the standard's columns are
# refitted at every step. The penalty is the extended BIC's: with a library this large the plain
# one alarms too often (Schwarz, Ann. Stat. 6, 1978; Chen & Chen, Biometrika 95, 2008).

BIC_THRESHOLD = 1.6  # gain of one column in ln n: the plain criterion asks for 1
MOST = 8  # columns of a channel

Step = tuple[int, float]  # library column, gain in ln n


def stepwise_bic(observation: Observation) -> Answer:
    """What each channel chooses; named where its columns have one fair reading."""
    steps = [[] if each is None else chosen(each, _rows(observation, c))
             for c, each in enumerate(observation.equations)]  # fmt: skip
    taken = [[step for step in one if step[1] > BIC_THRESHOLD] for one in steps]
    statistic = max((one[0][1] for one in steps if one), default=0.0)
    names, located = [], []
    for c, mine in enumerate(taken):
        for k, gain in mine:
            regressor = observation.equations[c].names[k]  # type: ignore[union-attr]
            names.append((gain, reading_of(c, regressor) or UNNAMED))
            located.append(Located(CHANNELS[c], dimension_of(regressor), regressor, gain))
    located.sort(key=lambda one: -one.strength)
    which = [[k for k, _ in mine] for mine in taken]
    found = predicted(observation, which) if names else None
    held_out = unseen(observation.equations, which)
    return Answer(statistic, BIC_THRESHOLD, tuple(located), in_order(names), found, held_out)


def _rows(observation: Observation, channel: int) -> int:
    return int((observation.observed.weight[:, channel] > 0).sum())


def chosen(equations: Equations, rows: int) -> list[Step]:
    """Columns in the order taken, with their gains; the first one whatever it gains."""
    whole = equations.without(None)
    normal, right, open_ = partialled_out(whole, equations.base)
    power = np.diag(whole)[equations.base : -1].copy()
    misfit = float(_rest(whole, equations.base))
    steps: list[Step] = []
    while len(steps) < MOST:
        size = np.diag(normal).copy()
        open_ = open_ & (size > SAME * power)
        gains = np.where(open_, right**2 / np.where(open_, size, 1.0), 0.0)
        best = int(np.argmax(gains))
        gain = rows * np.log(misfit / max(misfit - gains[best], 1e-300)) / np.log(rows)
        if steps and gain <= BIC_THRESHOLD:
            break
        steps.append((best, float(gain)))
        misfit -= gains[best]
        column = normal[:, best] / size[best]
        right = right - column * right[best]
        normal = normal - np.outer(column, normal[best])
        open_[best] = False
    return steps


def _rest(gram: np.ndarray, base: int) -> float:
    """Squared sum that the standard's columns alone leave."""
    shared = gram[:base, -1]
    return float(gram[-1, -1] - shared @ np.linalg.pinv(gram[:base, :base], 1e-11, True) @ shared)


ANSWER, PREDICTION = "peers.json", "peers.parquet"
PEERS: Mapping[str, Callable[[Observation], Answer]] = {
    "residual_threshold": residual_threshold,
    "stepwise_bic": stepwise_bic,
    "sindy": sindy,
    "gp_discrepancy": gp_discrepancy,
}

Predictions = dict[str, np.ndarray]


def answer_peers(recording: Recording, folder: Path) -> None:
    """Writes peers.json and peers.parquet to folder/. A failure is an answer, too.

    peers.parquet: at each block `<channel>_nominal`, the standard's model as the peers fit it, and
    `<channel>_<peer>` where a peer predicts something else; float32.
    """
    folder.mkdir(parents=True, exist_ok=True)
    started = time.perf_counter()
    response: dict[str, Any] = {"format": "mimu-peers/1", "block_rate": BLOCK_RATE}
    try:
        observation = see(recording)
    except Exception as failure:
        response["failed"] = _why(failure)
        response["peers"] = {name: _failed(failure, 0.0) for name in PEERS}
    else:
        response["noise"] = {CHANNELS[c]: _block_noise(observation, c) for c in observation.used}
        response["prepared_in"] = time.perf_counter() - started
        response["peers"], predictions = _answers(observation)
        pq.write_table(pa.table(predictions), folder / PREDICTION, compression="zstd")
    response["seconds"] = time.perf_counter() - started
    (folder / ANSWER).write_text(
        json.dumps(response, indent=1, ensure_ascii=False), encoding="utf-8"
    )


def _answers(observation: Observation) -> tuple[dict[str, Any], Predictions]:
    known = np.asarray((observation.observed.weight > 0).any(axis=1))
    predictions = {
        f"{channel}_nominal": np.where(known, observation.nominal[:, c], np.nan).astype(np.float32)
        for c, channel in enumerate(CHANNELS)
    }
    response = {}
    for name, peer in PEERS.items():
        started = time.perf_counter()
        try:
            found = peer(observation)
        except Exception as failure:
            response[name] = _failed(failure, time.perf_counter() - started)
            continue
        response[name] = _response(found, time.perf_counter() - started)
        predictions |= _changed(name, found, observation, known)
    return response, predictions


def _changed(name: str, answer: Answer, observation: Observation, known: np.ndarray) -> Predictions:
    """The channels of which a peer predicts something else than the standard's model."""
    if answer.found is None:
        return {}
    return {
        f"{CHANNELS[c]}_{name}": np.where(known, answer.found[:, c], np.nan).astype(np.float32)
        for c in observation.used
        if not np.array_equal(answer.found[:, c], observation.nominal[:, c])
    }


def _response(answer: Answer, seconds: float) -> dict[str, Any]:
    return {
        "detected": answer.detected,
        "statistic": answer.statistic,
        "threshold": answer.threshold,
        "located": [
            {
                "channel": each.channel,
                "dimension": each.dimension,
                "description": each.description,
                "segments": list(each.segments),
                "strength": each.strength,
            }
            for each in answer.located
        ],
        "names": list(answer.names),
        "held_out_rms_ratio": answer.held_out.rms_ratio,
        "held_out_gain": answer.held_out.gain,
        "seconds": seconds,
        "failed": None,
    }


def _failed(failure: Exception, seconds: float) -> dict[str, Any]:
    nothing = _response(Answer(0.0, 0.0), seconds)
    return nothing | {"failed": _why(failure)}


def _why(failure: Exception) -> str:
    return f"{type(failure).__name__}: {failure}"


def _block_noise(observation: Observation, channel: int) -> float:
    """Standard deviation of one block's white noise, rad/s or m/s²."""
    return float(np.sqrt(observation.noises[channel].white * BLOCK_RATE / 2.0))
