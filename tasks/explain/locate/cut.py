"""The one moment before and after which an excess differs most: a jump, a start, an end."""

import numpy as np

from tasks.explain.locate.patterns import FLOOR, Pattern, Seen, followed, paid
from tasks.explain.locate.run import Run

EARLIEST = 0.02  # of the run
SEEN = 1e-3  # of the rows before it: a jump of which less is left is taken up


def by_cut(run: Run, seen: Seen) -> Pattern | None:
    """A jump at the moment that takes up most, or the moment that parts the power best."""
    ends = np.cumsum([seen.sums.rows, seen.sums.first, seen.sums.second], axis=1)
    share = ends[0] / ends[0, -1]
    at = np.flatnonzero((share > EARLIEST) & (share < 1 - EARLIEST))
    if not len(at):
        return None
    cost = paid(2, run.pieces, run.pieces)
    jumps, steps = _jumps(seen, at, ends)
    parts = _parts(at, ends)
    if followed(float(jumps.max())) >= parts.max():
        best = int(jumps.argmax())
        cut, step = float(run.t[at[best]]), seen.shown(float(steps[best]))
        text = (
            f"{jumps[best]:.0%} of it is a step of {step} at {cut:.4g} s",
            f"{jumps[best]:.0%} 为 {cut:.4g} s 处 {step} 的阶跃",
        )
        score = followed(float(jumps[best])) - cost
        return Pattern("time", score, text, np.ones(len(run.t), bool))
    best = int(parts.argmax())
    cut, after = float(run.t[at[best]]), 1.0 - float(ends[2, at[best]] / ends[2, -1])
    later = after >= 0.5
    text = (
        f"{max(after, 1 - after):.0%} of it {'after' if later else 'before'} {cut:.4g} s",
        f"{max(after, 1 - after):.0%} 在 {cut:.4g} s {'之后' if later else '之前'}",
    )
    return Pattern("time", float(parts[best]) - cost, text, (run.t > cut) == later)


def _jumps(seen: Seen, at: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Share of the power that a jump at each moment takes up, and its size."""
    within = np.cumsum(seen.within, axis=0)[at]
    left = ends[0, at] - np.einsum("mi,ij,mj->m", within, seen.columns.inverse, within)
    left = np.maximum(left, SEEN * ends[0, at])
    return ends[1, at] ** 2 / left / seen.power, -ends[1, at] / left


def _parts(at: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Nats a row that power before and after each moment tells."""
    before = ends[:, at]
    after = ends[:, -1:] - before
    mean = ends[2, -1] / ends[0, -1]
    told = np.zeros(len(at))
    for rows, first, second in (before, after):
        left = np.maximum(second - first**2 / rows, 0.0) / rows
        told += rows / ends[0, -1] * np.log((1 + FLOOR) * mean / (left + FLOOR * mean))
    return 0.5 * told
