"""Where the excess sits: a recording cut into cells of time, and each cell held against noise."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from schemas.recording import Segment
from tasks.explain.channels import CHANNELS
from tasks.explain.explanation import Explanation
from tasks.segments.find import segments_of

FINEST = 240  # cells over the run where no segment asks for more
SLIVER = 0.25  # of a cell; nearer edges are taken as one
BLOCKS = (1, 8, 64)  # rows averaged before they are judged; and the whole cell, the whole segment
TO_SIGMA = 1.4826  # median absolute deviation to standard deviation, normal distribution
STEP_TO_SIGMA = np.sqrt(np.pi) / 2.0  # mean size of a step from row to row, likewise


@dataclass(frozen=True)
class Cells:
    """Cells of time, k of them, and what the six channels do in each.

    edges: (k+1,) s on the unit's clock. segments: those of the recording; kinds: of each cell,
    "" between segments. excess: (6, k) standard deviations that the nominal model's misfit
    stands above noise. before, after: (6, k) mean residual without and with the findings, SI;
    swing_before, swing_after: (6, k) rms of what swings inside a cell beyond noise, SI; noise:
    (6, k) standard deviation of a mean by noise. NaN where nothing is known.
    """

    edges: np.ndarray
    segments: tuple[Segment, ...]
    kinds: tuple[str, ...]
    excess: np.ndarray
    before: np.ndarray
    after: np.ndarray
    swing_before: np.ndarray
    swing_after: np.ndarray
    noise: np.ndarray


def cells_of(explanation: Explanation) -> Cells:
    """The cells of an explanation: cut at the ends of segments, and finely in between."""
    recording = explanation.recording
    t = recording.imu.t
    segments = segments_of(recording)
    edges = _edges(t, segments)
    rows = np.searchsorted(t, edges)
    rows[-1] = len(t)
    stretches = _stretches(edges, segments)
    readings = recording.imu.stack(CHANNELS)
    made = [
        _channel(readings[:, i] - explanation.nominal[:, i],
                 readings[:, i] - explanation.found[:, i], rows, stretches,
                 float(explanation.noise[i]))
        for i in range(len(CHANNELS))
    ]  # fmt: skip
    return Cells(edges, segments, _kinds(edges, segments), *np.stack(made, axis=1))


def _edges(t: np.ndarray, segments: tuple[Segment, ...]) -> np.ndarray:
    start, end = float(t[0]), float(t[-1])
    width = max(end - start, 1e-9) / FINEST
    ends = [edge for s in segments for edge in (s.t_start, s.t_end) if start < edge < end]
    kept = [start]
    for edge in [*sorted(ends), end]:
        if edge - kept[-1] < SLIVER * width:
            continue
        pieces = int(np.ceil((edge - kept[-1]) / width))
        kept += np.linspace(kept[-1], edge, pieces + 1)[1:].tolist()
    kept[-1] = end if len(kept) > 1 else kept[-1]
    return np.array(kept if len(kept) > 1 else [start, start + width])


def _kinds(edges: np.ndarray, segments: tuple[Segment, ...]) -> tuple[str, ...]:
    kinds = [""] * (len(edges) - 1)
    middles = 0.5 * (edges[:-1] + edges[1:])
    for segment in segments:
        first, last = np.searchsorted(middles, (segment.t_start, segment.t_end))
        kinds[first:last] = [segment.kind] * (last - first)
    return tuple(kinds)


def _stretches(edges: np.ndarray, segments: tuple[Segment, ...]) -> np.ndarray:
    """(k,) a number for each cell that is the same within one segment, and between two."""
    middles = 0.5 * (edges[:-1] + edges[1:])
    ends = sorted(end for each in segments for end in (each.t_start, each.t_end))
    return np.unique(np.searchsorted(ends, middles), return_inverse=True)[1]


def _channel(
    before: np.ndarray, after: np.ndarray, rows: np.ndarray, stretches: np.ndarray, noise: float
) -> np.ndarray:
    """(6, k): excess, mean before, after, swing before, after, noise of a mean of one channel."""
    known = np.isfinite(before)
    after = np.where(np.isfinite(after), after, before)
    cells = [slice(a, b) for a, b in pairwise(rows)]
    firsts = [before[cell][known[cell]] for cell in cells]
    lasts = [after[cell][known[cell]] for cell in cells]
    sigmas = np.array([_white(values, noise) for values in lasts])
    means = np.array([[_mean(v) for v in values] for values in (firsts, lasts)])
    swings = np.array([[_swing(v, s) for v, s in zip(values, sigmas, strict=True)]
                       for values in (firsts, lasts)])  # fmt: skip
    counts = np.array([len(values) or np.nan for values in firsts])
    scaled = [values / s for values, s in zip(firsts, sigmas, strict=True)]
    rest = [values / s for values, s in zip(lasts, sigmas, strict=True)]
    return np.vstack([_excess(scaled, rest, stretches), means, swings, sigmas / np.sqrt(counts)])


def _white(values: np.ndarray, noise: float) -> float:
    """Standard deviation of the fast noise in a cell, from its differences; at least `noise`.

    It may be more than at rest: a table in motion shakes what stands on it.
    """
    sigma = noise if np.isfinite(noise) and noise > 0 else 0.0
    if len(values) > BLOCKS[1]:
        sigma = max(sigma, STEP_TO_SIGMA * float(np.mean(np.abs(np.diff(values)))))
    return sigma or 1e-12


def _mean(values: np.ndarray) -> float:
    return float(values.mean()) if len(values) else np.nan


def _swing(values: np.ndarray, sigma: float) -> float:
    """rms about the mean beyond noise; 0 where chance would do as much."""
    if len(values) < BLOCKS[1]:
        return 0.0 if len(values) else np.nan
    beyond = float(values.var()) - sigma**2
    return np.sqrt(beyond) if beyond > 4.0 * sigma**2 * np.sqrt(2.0 / len(values)) else 0.0


def _excess(cells: list[np.ndarray], rest: list[np.ndarray], stretches: np.ndarray) -> np.ndarray:
    """How far each cell's power stands above that of noise, at the block where it shows most.

    rest: what is left when the findings are in the model. Noise that is not white is stronger
    in long blocks: its size there is the Allan deviation of the rest.
    """
    shown = np.full((len(BLOCKS) + 2, len(cells)), np.nan)
    for i, block in enumerate((*BLOCKS, None)):
        sums = [_block_sums(values, block) for values in cells]
        size = _allan([_block_sums(values, block) for values in rest])
        shown[i] = [_deviate(each / size) for each in sums]
    whole, left = (_whole(each, stretches) for each in (cells, rest))
    counts = np.bincount(stretches, [len(each) for each in rest])
    size = _allan([each for each, n in zip(left, counts, strict=True) if n > counts.max() / 4])
    seen = np.array([_deviate(each / size) for each in whole])[stretches]
    shown[-1] = np.where([len(each) > 0 for each in cells], seen, np.nan)
    known = np.isfinite(shown).any(axis=0)
    return np.where(known, np.max(np.nan_to_num(shown, nan=-np.inf), axis=0), np.nan)


def _whole(cells: list[np.ndarray], stretches: np.ndarray) -> list[np.ndarray]:
    """One block for each stretch."""
    last = int(stretches.max()) + 1
    sums = np.bincount(stretches, [each.sum() for each in cells], last)
    counts = np.bincount(stretches, [len(each) for each in cells], last)
    return [np.array([s / np.sqrt(n)]) if n else np.zeros(0) for s, n in zip(sums, counts,
            strict=True)]  # fmt: skip


def _block_sums(values: np.ndarray, block: int | None) -> np.ndarray:
    """Means of blocks times the root of their length: of variance 1 for white noise."""
    length = block or max(len(values), 1)
    count = len(values) // length
    return values[: count * length].reshape(count, length).sum(axis=1) / np.sqrt(length)


def _allan(cells: list[np.ndarray]) -> float:
    """Allan deviation of blocks, robust, at least 1; over cells where each holds one block."""
    steps = [np.diff(each) for each in cells if len(each) > 1]
    jumps = np.concatenate(steps) if steps else np.diff(np.concatenate([*cells, np.zeros(0)]))
    if not len(jumps):
        return 1.0
    return max(1.0, TO_SIGMA * float(np.median(np.abs(jumps))) / np.sqrt(2.0))


def _deviate(sums: np.ndarray) -> float:
    """The normal deviate of their chi-squared (Wilson and Hilferty, PNAS 17 (1931) 684)."""
    n = len(sums)
    if not n:
        return np.nan
    return float((np.cbrt(np.mean(sums**2)) - (1 - 2 / (9 * n))) / np.sqrt(2 / (9 * n)))
