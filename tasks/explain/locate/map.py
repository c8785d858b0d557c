"""Where reading and model differ over the run, for a picture: six channels by cells of time."""

from dataclasses import dataclass

import numpy as np

from tasks.explain.explanation import CHANNELS, Explanation
from tasks.explain.locate.excess import scales
from tasks.explain.locate.run import segments_of

LONGEST = 1 / 50  # of the run: a longer segment is more cells than one


@dataclass(frozen=True)
class ExcessMap:
    """Standardised misfit in k cells of time.

    t_edges: (k + 1,) s. segments: (k,) the name of the one a cell lies in, empty for none.
    before, after: (6, k) mean of reading − prediction over σ/√n, without and with the findings;
    NaN where nothing is predicted.
    """

    t_edges: np.ndarray
    segments: tuple[str, ...]
    before: np.ndarray
    after: np.ndarray


def excess_map(explanation: Explanation) -> ExcessMap:
    """The misfit of both models, cell by cell; cells end where segments do."""
    recording = explanation.recording
    t = recording.imu.t
    start, stop = float(t[0]), float(t[-1])
    segments = segments_of(recording)
    ends = [end for each in segments for end in (each.t_start, each.t_end)]
    edges = np.unique(np.clip([start, *ends, stop], start, stop))
    edges = _split(edges, (stop - start) * LONGEST)
    names = [""] * (len(edges) - 1)
    for each in segments:
        first, last = np.searchsorted(edges, (each.t_start, each.t_end))
        names[first:last] = [each.name] * (min(last, len(names)) - first)
    cell = np.clip(np.searchsorted(edges, t, "right") - 1, 0, len(names) - 1)
    readings, noise = recording.imu.stack(CHANNELS), scales(explanation.noise)
    before, after = (
        np.stack([
            _standardised(readings[:, c] - predicted[:, c], cell, len(names)) / noise[c]
            for c in range(6)
        ])
        for predicted in (explanation.nominal, explanation.found)
    )  # fmt: skip
    return ExcessMap(edges, tuple(names), before, after)


def _split(edges: np.ndarray, longest: float) -> np.ndarray:
    """The same edges with those between that long cells need."""
    pieces = np.maximum(1, np.ceil(np.diff(edges) / longest - 1e-9).astype(int))
    inner = [
        np.linspace(a, b, n, endpoint=False)
        for a, b, n in zip(edges[:-1], edges[1:], pieces, strict=True)
    ]
    return np.concatenate([*inner, edges[-1:]])


def _standardised(misfit: np.ndarray, cell: np.ndarray, count: int) -> np.ndarray:
    """Σ/√n of each cell's known rows: its mean over that of noise of size 1."""
    known = np.isfinite(misfit)
    rows = np.bincount(cell[known], minlength=count)
    sums = np.bincount(cell[known], misfit[known], count)
    return np.where(rows > 0, sums / np.sqrt(np.maximum(rows, 1)), np.nan)
