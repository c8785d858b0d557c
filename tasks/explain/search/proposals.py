"""Proposes instants at which a bias may have stepped, and periods of recurring contributions.

A grid of times or periods fine enough to miss nothing would have hundreds of columns. The
whitened residual shows for all of them at once how much each would gain; the best few become the
shapes of the candidates.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.fft import rfft, rfftfreq

from tasks.explain.residual_noise import ChannelResidual
from tasks.explain.search.candidates import STEP_TIMES, Candidate, columns_of, members_of
from tasks.explain.search.design import BandedDesign, ChannelDesign, residuals, with_columns
from tasks.explain.search.empirical import SINUSOIDS
from tasks.explain.whitening import (
    Noise,
    at_blocks,
    in_band,
    in_time,
    padded_length,
    weighted,
)
from tasks.model.regression import inverse
from tasks.model.term import Term

TIME, PERIOD = "time", "period"
STEP_DISTANCE = 15.0  # s between two proposed steps
CORRELATED = 5.0  # s within which two steps look alike in a noise that drifts
STEP_GRID = 24  # times at which a step's own size is computed; between them it is smooth
MIN_PERIODS = 4.0  # of a sinusoid in a run
MAX_FREQUENCY = 1.0  # Hz
OVERSAMPLING = 4  # points of the spectrum for each independent one


def with_proposed_shapes(
    design: BandedDesign,
    candidates: Sequence[Candidate],
    noises: Sequence[Noise],
    selected: Sequence[Candidate] = (),
    beside: Sequence[Candidate] | None = None,
) -> tuple[BandedDesign, list[Candidate]]:
    """Design and candidates with the best times for steps and the best periods for sinusoids.

    selected: candidates that stay as they are. beside: the candidates beside which the others are
    proposed; the selected ones if not given.
    """
    left = residuals(design, members_of(selected if beside is None else beside), noises)
    terms = _proposed_terms(design, candidates, noises, selected, left)
    span = len(design.blocks.t) / design.blocks.rate
    columns, updated = {}, []
    for candidate in candidates:
        term = terms.get(candidate.term.key)
        if term is None:
            updated.append(candidate)
            continue
        fresh = columns_of(term, design.blocks.motion)
        columns.update({p: fresh[q] for p, q in zip(candidate.members, candidate.own, strict=True)})
        independent = span / CORRELATED if _shape(term) == TIME else span * MAX_FREQUENCY
        updated.append(replace(candidate, term=term, shape_trials=independent))
    return with_columns(design, columns), updated


def _shape(term: Term) -> str:
    """The name of its only shape; nothing where it has none or several."""
    return term.shapes[0].name if len(term.shapes) == 1 else ""


def _proposed_terms(
    design: BandedDesign,
    candidates: Sequence[Candidate],
    noises: Sequence[Noise],
    selected: Sequence[Candidate],
    left: Sequence[ChannelResidual],
) -> Mapping[tuple[str, int], Term]:
    """The terms with a time or a period, but those selected, with their proposed shapes, by key."""
    steps, sinusoids = _gains(design, left, noises)
    held = {candidate.term.key for candidate in selected}
    shapes: dict[tuple[str, tuple[int, ...]], list[float]] = {}
    terms: dict[tuple[str, int], Term] = {}
    for candidate in candidates:
        shape = _shape(candidate.term)
        if shape not in (TIME, PERIOD) or candidate.term.key in held | set(terms):
            continue
        channels = tuple(sorted({c for p in candidate.members for c in design.columns[p]}))
        if (shape, channels) not in shapes:
            gain = (steps if shape == TIME else sinusoids)[list(channels)].sum(axis=0)
            best = _best_times if shape == TIME else _best_periods
            shapes[shape, channels] = best(gain, design)
        if shapes[shape, channels]:
            terms[candidate.term.key] = candidate.term.shaped((shapes[shape, channels].pop(0),))
    return terms


def _gains(
    design: BandedDesign, left: Sequence[ChannelResidual], noises: Sequence[Noise]
) -> tuple[np.ndarray, np.ndarray]:
    """Chi-squared of a step at each time (6, n) and of a sinusoid of each frequency (6, m)."""
    steps = np.zeros((len(left), len(design.blocks.t)))
    sinusoids = np.zeros((len(left), len(_frequencies(design))))
    for c, channel in enumerate(design.channels):
        if channel is not None:
            score = _score(design, c, left[c], noises[c])
            steps[c] = _step_gains(design, c, channel, score, noises[c])
            sinusoids[c] = _sinusoid_gains(design, c, score, noises[c])
    return steps, sinusoids


def _score(design: BandedDesign, c: int, left: ChannelResidual, noise: Noise) -> np.ndarray:
    """(n,) residual divided by the noise's covariance: its product with a column is a score."""
    weight = design.blocks.weight[:, c]
    whitened = left.coefficients / noise.of_coefficients(design.bands)
    padded = padded_length(len(design.blocks.compared))
    return at_blocks(in_time(whitened, padded)[None], design.blocks)[0] * weight


def _step_gains(
    design: BandedDesign, c: int, channel: ChannelDesign, score: np.ndarray, noise: Noise
) -> np.ndarray:
    """(n,) chi-squared that a step at each time would gain in one channel."""
    count = len(score)
    root = np.sqrt(noise.of_coefficients(design.bands))
    at = np.linspace(0.02 * count, 0.98 * count, STEP_GRID).astype(int)
    rows = np.arange(count)
    later = [np.where(rows >= start, 1.0, 0.0) for start in at]
    stack = weighted(later, design.blocks.weight[:, c], design.blocks)
    steps = in_band(stack, design.blocks) / root
    base = channel.base / root
    shared = steps @ base.T
    size = (steps**2).sum(axis=1)
    size = size - np.einsum("kb,bd,kd->k", shared, inverse(base @ base.T), shared)
    summed = np.cumsum(score[::-1])[::-1]
    known = np.interp(rows, at, np.maximum(size, 1e-300))
    return np.asarray(summed**2 / known)


def _sinusoid_gains(design: BandedDesign, c: int, score: np.ndarray, noise: Noise) -> np.ndarray:
    """(m,) chi-squared that a sinusoid of each frequency would gain in one channel."""
    power = np.abs(rfft(score, OVERSAMPLING * len(score))) ** 2
    frequency = _frequencies(design)
    weight = float((design.blocks.weight[:, c] ** 2).sum())
    variance = noise.variance(np.maximum(frequency, frequency[1]))
    return np.asarray(2.0 * power * variance / max(weight, 1e-300))


def _frequencies(design: BandedDesign) -> np.ndarray:
    return np.asarray(rfftfreq(OVERSAMPLING * len(design.blocks.t), 1.0 / design.blocks.rate))


def _best_times(gain: np.ndarray, design: BandedDesign) -> list[float]:
    t, edge = design.blocks.t, len(gain) // 50
    inner = np.zeros_like(gain)
    inner[edge : len(gain) - edge] = gain[edge : len(gain) - edge]
    best = _best(inner, STEP_TIMES, lambda k: np.abs(t - t[k]) < STEP_DISTANCE)
    return [float(t[k]) for k in best]


def _best_periods(gain: np.ndarray, design: BandedDesign) -> list[float]:
    frequency = _frequencies(design)
    span = len(design.blocks.t) / design.blocks.rate
    inner = np.where((frequency > MIN_PERIODS / span) & (frequency < MAX_FREQUENCY), gain, 0.0)
    best = _best(inner, SINUSOIDS, lambda k: np.abs(frequency - frequency[k]) < 2.0 / span)
    return [float(1.0 / frequency[k]) for k in best]


def _best(gain: np.ndarray, count: int, near: Callable[[int], np.ndarray]) -> list[int]:
    """Where gain (n,) is largest, at most `count` times, nothing near (n,) bool another."""
    found: list[int] = []
    left = gain.copy()
    for _ in range(count):
        best = int(np.argmax(left))
        if left[best] <= 0:
            break
        found.append(best)
        left[near(best)] = 0.0
    return found
