"""The change point of an excess: the moment before and after which it differs most."""

import numpy as np

from tasks.explain.locate.excess import MIN_VISIBLE, ChannelExcess
from tasks.explain.locate.patterns import FLOOR, Pattern, cost, fit_information
from tasks.explain.locate.run import Run
from tasks.words import message

MARGIN = 0.02  # of the run at either end, without change points


def change_point_pattern(run: Run, excess: ChannelExcess) -> Pattern | None:
    """A step at the moment that absorbs most, or the moment that parts the power best."""
    moments = excess.moments
    ends = np.cumsum([moments.rows, moments.first, moments.second], axis=1)
    share = ends[0] / ends[0, -1]
    at = np.flatnonzero((share > MARGIN) & (share < 1 - MARGIN))
    if not len(at):
        return None
    paid = cost(2, run.intervals, run.intervals)
    absorbed, steps = _steps(excess, at, ends)
    parts = _power_changes(at, ends)
    if fit_information(float(absorbed.max())) >= parts.max():
        best = int(absorbed.argmax())
        description = message(
            "locate-step", share=f"{absorbed[best]:.0%}",
            step=excess.formatted(float(steps[best])), time=f"{run.t[at[best]]:.4g}",
        )  # fmt: skip
        score = fit_information(float(absorbed[best])) - paid
        return Pattern("time", score, description, np.ones(len(run.t), bool))
    best = int(parts.argmax())
    change, after = float(run.t[at[best]]), 1.0 - float(ends[2, at[best]] / ends[2, -1])
    later = after >= 0.5
    description = message(
        "locate-after" if later else "locate-before",
        share=f"{max(after, 1 - after):.0%}", time=f"{change:.4g}",
    )  # fmt: skip
    return Pattern("time", float(parts[best]) - paid, description, (run.t > change) == later)


def _steps(
    excess: ChannelExcess, at: np.ndarray, ends: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Share of the power that a step at each moment absorbs, and its size."""
    sums = np.cumsum(excess.sums, axis=0)[at]
    rows = ends[0, at]
    left = rows - np.einsum("mi,ij,mj->m", sums, excess.design.inverse, sums)
    left = np.maximum(left, MIN_VISIBLE * rows)
    return ends[1, at] ** 2 / left / excess.power, -ends[1, at] / left


def _power_changes(at: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Nats a row that the power before and after each moment gives."""
    before = ends[:, at]
    after = ends[:, -1:] - before
    mean = ends[2, -1] / ends[0, -1]
    nats = np.zeros(len(at))
    for rows, first, second in (before, after):
        left = np.maximum(second - first**2 / rows, 0.0) / rows
        nats += rows / ends[0, -1] * np.log((1 + FLOOR) * mean / (left + FLOOR * mean))
    return 0.5 * nats
