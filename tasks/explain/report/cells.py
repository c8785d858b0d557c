"""Divides a recording into cells of time and compares the excess in each with the noise."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from schemas.recording import Segment
from tasks.explain.channels import CHANNELS
from tasks.explain.explanation import Explanation
from tasks.explain.inputs.shown_segments import shown_segments
from tasks.readings.robust import TO_SIGMA

FINEST = 240  # cells over the run where no segment asks for more
SLIVER = 0.25  # of a cell; nearer edges are taken as one
BLOCKS = (1, 8, 64, None)  # rows averaged before they are judged; None: the whole cell
ENOUGH = 8  # rows from which the fast noise and the swing of a cell are known
STEP_TO_SIGMA = np.sqrt(np.pi) / 2.0  # mean size of a step from row to row, likewise

Parts = Sequence[np.ndarray]  # the known rows of each cell


@dataclass(frozen=True)
class ExcessCells:
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


def cells_of(explanation: Explanation) -> ExcessCells:
    """The cells of an explanation: cut at the ends of segments, and finely in between."""
    t = explanation.recording.imu.t
    segments = shown_segments(explanation.recording)
    edges = _edges(t, segments)
    middles = 0.5 * (edges[:-1] + edges[1:])
    rows = np.searchsorted(t, edges)
    rows[-1] = len(t)
    cells = [slice(*ends) for ends in pairwise(rows)]
    # A number for each cell that is the same within one segment, and between two.
    ends = sorted(end for segment in segments for end in (segment.t_start, segment.t_end))
    interval = np.unique(np.searchsorted(ends, middles), return_inverse=True)[1]
    readings = explanation.recording.imu.stack(CHANNELS)
    before, after = readings - explanation.nominal, readings - explanation.found
    after = np.where(np.isfinite(after), after, before)
    channels = []
    for i, noise in enumerate(explanation.noise):
        known = [np.arange(cell.start, cell.stop)[np.isfinite(before[cell, i])] for cell in cells]
        first, last = ([values[rows, i] for rows in known] for values in (before, after))
        channels.append(_channel(first, last, interval, float(noise)))
    kinds = [""] * len(cells)
    for segment in segments:
        first, last = np.searchsorted(middles, (segment.t_start, segment.t_end))
        kinds[first:last] = [segment.kind] * (last - first)
    return ExcessCells(edges, segments, tuple(kinds), *np.stack(channels, axis=1))


def _edges(t: np.ndarray, segments: tuple[Segment, ...]) -> np.ndarray:
    start, end = float(t[0]), float(t[-1])
    width = max(end - start, 1e-9) / FINEST
    ends = [edge for s in segments for edge in (s.t_start, s.t_end) if start < edge < end]
    kept = [start]
    for edge in [*sorted(ends), end]:
        if edge - kept[-1] >= SLIVER * width:
            pieces = int(np.ceil((edge - kept[-1]) / width))
            kept += np.linspace(kept[-1], edge, pieces + 1)[1:].tolist()
    return np.array([*kept[:-1], end] if len(kept) > 1 else [start, start + width])


def _channel(before: Parts, after: Parts, interval: np.ndarray, noise: float) -> np.ndarray:
    """(6, k): excess, mean before, after, swing before, after, noise of a mean of one channel."""
    sigmas = np.array([_fast_noise(values, noise) for values in after])
    means = [[values.mean() if len(values) else np.nan for values in parts]
             for parts in (before, after)]  # fmt: skip
    swings = [[_swing(values, s) for values, s in zip(parts, sigmas, strict=True)]
              for parts in (before, after)]  # fmt: skip
    counts = np.array([len(values) or np.nan for values in before])
    whitened, rest = ([values / s for values, s in zip(parts, sigmas, strict=True)]
                      for parts in (before, after))  # fmt: skip
    excess = _excess(whitened, rest, interval)
    return np.vstack([excess, *means, *swings, sigmas / np.sqrt(counts)])


def _fast_noise(values: np.ndarray, noise: float) -> float:
    """Standard deviation of the fast noise in a cell, from its differences; at least `noise`.

    It may be more than at rest: a table in motion shakes what stands on it.
    """
    sigma = noise if np.isfinite(noise) and noise > 0 else 0.0
    if len(values) > ENOUGH:
        sigma = max(sigma, STEP_TO_SIGMA * float(np.mean(np.abs(np.diff(values)))))
    return sigma or 1e-12


def _swing(values: np.ndarray, sigma: float) -> float:
    """rms about the mean beyond noise; 0 where chance would do as much."""
    if len(values) < ENOUGH:
        return 0.0 if len(values) else np.nan
    beyond = float(values.var()) - sigma**2
    return np.sqrt(beyond) if beyond > 4.0 * sigma**2 * np.sqrt(2.0 / len(values)) else 0.0


def _excess(whitened: Parts, rest: Parts, interval: np.ndarray) -> np.ndarray:
    """How far each cell's power exceeds that of noise, at the block length where it shows most.

    rest: the residual with the findings in the model. Noise that is not white is stronger in long
    blocks: its size there is the Allan deviation of the rest. The last and longest blocks are whole
    segments, and the time between two.
    """
    deviates = []
    for block in BLOCKS:
        size = _allan_deviation([_blocks(values, block) for values in rest])
        deviates.append([_deviate(_blocks(values, block) / size) for values in whitened])
    whole, left = (_joined(parts, interval) for parts in (whitened, rest))
    longest = max(map(len, left))
    size = _allan_deviation([_blocks(values, None) for values in left if len(values) > longest / 4])
    of_interval = np.array([_deviate(_blocks(values, None) / size) for values in whole])
    has_rows = np.array([len(values) > 0 for values in whitened])
    shown = np.array([*deviates, np.where(has_rows, of_interval[interval], np.nan)])
    largest = np.max(np.nan_to_num(shown, nan=-np.inf), axis=0)
    return np.where(np.isfinite(shown).any(axis=0), largest, np.nan)


def _joined(parts: Parts, interval: np.ndarray) -> Parts:
    """The rows of each interval."""
    return [
        np.concatenate([part for part, number in zip(parts, interval, strict=True) if number == k])
        for k in range(interval.max() + 1)
    ]


def _blocks(values: np.ndarray, block: int | None) -> np.ndarray:
    """Means of blocks times the root of their length: of variance 1 for white noise."""
    length = block or max(len(values), 1)
    count = len(values) // length
    return values[: count * length].reshape(count, length).sum(axis=1) / np.sqrt(length)


def _allan_deviation(cells: Parts) -> float:
    """Allan deviation of blocks, robust, at least 1; over cells where each holds one block."""
    steps = [np.diff(blocks) for blocks in cells if len(blocks) > 1]
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
