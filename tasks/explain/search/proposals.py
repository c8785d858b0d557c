"""When a bias may have jumped, and at which period something may come and go.

A grid of times or periods fine enough to miss nothing would have hundreds of columns. The
whitened residual tells at once, for all of them, how much each would gain; the best few are
tried in earnest.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.fft import idct, rfft, rfftfreq

from tasks.explain.inputs.observed import Observed
from tasks.explain.regression.spectrum import Noise, transformed
from tasks.explain.search.candidates import JUMPS, Candidate, columns_of
from tasks.explain.search.empirical import SINUSOIDS
from tasks.explain.search.pool import ChannelPool, Pool, inverse, renewed
from tasks.model.term import Term

APART = 15.0  # s between two proposed jumps
CORRELATED = 5.0  # s within which two jumps look alike in a noise that drifts
GRID = 24  # times at which a jump's own size is computed; between them it is smooth
SLOWEST, FASTEST = 4.0, 1.0  # periods in a run at least; Hz at most
FINER = 4  # points of the spectrum for each independent one


def proposed(
    pool: Pool,
    candidates: Sequence[Candidate],
    left: Sequence[np.ndarray],
    noises: Sequence[Noise],
    taken: Sequence[Candidate] = (),
) -> tuple[Pool, list[Candidate]]:
    """Pool and candidates with the best times for jumps and the best periods for waves.

    left: for each channel the transformed residual of what was found so far. taken: candidates
    that stay as they are.
    """
    jumps, waves = _gains(pool, left, noises)
    held = {one.term.key for one in taken}
    shapes: dict[tuple[str, tuple[int, ...]], list[float]] = {}
    terms: dict[tuple[str, int], Term] = {}
    for one in candidates:
        kind = [shape.name for shape in one.term.shapes]
        if kind not in (["time"], ["period"]) or one.term.key in held | set(terms):
            continue
        channels = tuple(sorted({c for p in one.members for c in pool.columns[p]}))
        key = (kind[0], channels)
        if key not in shapes:
            gain = (jumps if kind == ["time"] else waves)[list(channels)].sum(axis=0)
            best = _best_times if kind == ["time"] else _best_periods
            shapes[key] = best(gain, pool.observed)
        if shapes[key]:
            terms[one.term.key] = one.term.shaped((shapes[key].pop(0),))
    columns = {}
    for one in candidates:
        if one.term.key in terms:
            fresh = columns_of(terms[one.term.key], pool.observed.motion)
            columns.update({p: fresh[q] for p, q in zip(one.members, one.own, strict=True)})
    span = len(pool.observed.t) / pool.observed.rate
    moved = [
        replace(one, term=terms[one.term.key], looked=_looked(one, span))
        if one.term.key in terms
        else one
        for one in candidates
    ]
    return renewed(pool, columns, None), moved


def _looked(one: Candidate, span: float) -> float:
    """How many independent times or periods a proposal is the best of."""
    return span / CORRELATED if one.term.shapes[0].name == "time" else span * FASTEST


def _gains(
    pool: Pool, left: Sequence[np.ndarray], noises: Sequence[Noise]
) -> tuple[np.ndarray, np.ndarray]:
    """Chi-squared of a jump at each time (6, n) and of a wave of each frequency (6, m)."""
    jumps = np.zeros((6, len(pool.observed.t)))
    waves = np.zeros((6, len(_frequencies(pool.observed))))
    for c, channel in enumerate(pool.channels):
        if channel is not None:
            heard = _heard(pool, c, left[c], noises[c])
            jumps[c] = _jumps(pool, c, channel, heard, noises[c])
            waves[c] = _waves(pool.observed, c, heard, noises[c])
    return jumps, waves


def _heard(pool: Pool, c: int, left: np.ndarray, noise: Noise) -> np.ndarray:
    """(n,) residual divided by the noise's covariance: its product with a column is a score."""
    level = np.repeat(noise.variance(pool.bands.frequency), pool.bands.sizes)
    weight = pool.observed.weight[:, c]
    return np.asarray(idct(left / level, type=2, norm="ortho")[: len(weight)] * weight)


def _jumps(pool: Pool, c: int, channel: ChannelPool, heard: np.ndarray, noise: Noise) -> np.ndarray:
    """(n,) chi-squared that a jump at each time would gain in one channel."""
    count, length = len(heard), channel.base.shape[1]
    level = np.repeat(noise.variance(pool.bands.frequency), pool.bands.sizes)
    at = np.linspace(0.02 * count, 0.98 * count, GRID).astype(int)
    steps = np.zeros((GRID, length))
    for row, start in zip(steps, at, strict=True):
        row[start:count] = pool.observed.weight[start:, c]
    steps = transformed(steps) / np.sqrt(level)
    base = channel.base / np.sqrt(level)
    shared = steps @ base.T
    size = (steps**2).sum(axis=1)
    size = size - np.einsum("kb,bd,kd->k", shared, inverse(base @ base.T), shared)
    score = np.cumsum(heard[::-1])[::-1]
    known = np.interp(np.arange(count), at, np.maximum(size, 1e-300))
    return np.asarray(score**2 / known)


def _waves(observed: Observed, c: int, heard: np.ndarray, noise: Noise) -> np.ndarray:
    """(m,) chi-squared that a wave of each frequency would gain in one channel."""
    power = np.abs(rfft(heard, FINER * len(heard))) ** 2
    frequency = _frequencies(observed)
    weight = float((observed.weight[:, c] ** 2).sum())
    variance = noise.variance(np.maximum(frequency, frequency[1]))
    return np.asarray(2.0 * power * variance / max(weight, 1e-300))


def _frequencies(observed: Observed) -> np.ndarray:
    return np.asarray(rfftfreq(FINER * len(observed.t), 1.0 / observed.rate))


def _best_times(gain: np.ndarray, observed: Observed) -> list[float]:
    inner = np.zeros_like(gain)
    edge = len(gain) // 50
    inner[edge : len(gain) - edge] = gain[edge : len(gain) - edge]
    found = []
    for _ in range(JUMPS):
        best = int(np.argmax(inner))
        if inner[best] <= 0:
            break
        found.append(float(observed.t[best]))
        inner[np.abs(observed.t - observed.t[best]) < APART] = 0.0
    return found


def _best_periods(gain: np.ndarray, observed: Observed) -> list[float]:
    frequency = _frequencies(observed)
    span = len(observed.t) / observed.rate
    gain = np.where((frequency > SLOWEST / span) & (frequency < FASTEST), gain, 0.0)
    found = []
    for _ in range(SINUSOIDS):
        best = int(np.argmax(gain))
        if gain[best] <= 0:
            break
        found.append(float(1.0 / frequency[best]))
        gain[np.abs(frequency - frequency[best]) < 2.0 / span] = 0.0
    return found
