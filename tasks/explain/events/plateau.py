"""Plateaus: readings that stay constant while the prediction goes on.

A limit of the raw output need not be one code of the file: calibration, temperature and filters
spread it over hundreds of values, and each axis and side has its own. What shows it is the
prediction of all that lies below, carried on beyond it.
"""

from dataclasses import dataclass

import numpy as np

from tasks.explain.channels import EVERY
from tasks.model.fit import plain_prediction
from tasks.motion.whole import Motion

NEAR = 0.03  # of the largest reading: what may be disturbed by a limit, at first
TOPMOST = 8  # readings above the one that counts as the largest, for spikes
BEYOND = 1.02  # times the limit, from where on a prediction is beyond it, be it ever so noisy
MIN_BEYOND = 12  # readings whose prediction is beyond
APPROACH = 0.7  # of the limit, from where on the readings must follow the prediction
MIN_APPROACH = 30
MOSTLY = 0.5  # of the readings at a limit, whose prediction is beyond
FLAT = 0.1  # change of the reading with the prediction beyond a limit; one without it
REACH = 4.0  # times the plateau's own scatter, by which the prediction passes it
QUIET = 0.5  # of the scatter below a limit: noise is cut off
BELOW = 0.9  # of the limit: a scale factor that bends would have lost most of it there, too
LOST_BELOW = 0.2  # of what is lost beyond a limit: more is no limit
MAX_SCATTER = 0.01  # of the limit
ROUNDS = 2
TRIMMED = (0.05, 0.95)


@dataclass(frozen=True)
class Plateau:
    """Where a channel's readings end on one side (1.0 above, −1.0 below).

    limit: of the readings times the side. scatter: of the readings there. noise: of those below.
    count: readings there.
    """

    channel: int
    side: float
    limit: float
    scatter: float
    noise: float
    count: int


def find_plateaus(
    readings: np.ndarray, motion: Motion, masked: np.ndarray
) -> tuple[tuple[Plateau, ...], np.ndarray, np.ndarray]:
    """Every plateau of readings (n, 6), which of them they disturb, and what the rest predicts.

    masked: (n, 6) bool, readings that are known to be disturbed.
    """
    sides = [(c, side) for c in EVERY for side in (1.0, -1.0)]
    limits = {(c, side): _largest(side * readings[:, c]) for c, side in sides}
    disturbed = masked.copy()
    for (c, side), limit in limits.items():
        disturbed[:, c] |= side * readings[:, c] > (1.0 - NEAR) * limit
    for _ in range(ROUNDS):
        predicted = plain_prediction(readings, motion, disturbed)
        some = (_plateau(readings, predicted, *key, limit) for key, limit in limits.items())
        found = tuple(plateau for plateau in some if plateau is not None)
        disturbed = masked.copy()
        for one in found:
            edge = one.limit - REACH * (one.scatter + one.noise)
            disturbed[:, one.channel] |= one.side * predicted[:, one.channel] > edge
        if not found:
            break
    return found, disturbed, predicted


def _largest(values: np.ndarray) -> float:
    """The largest of values (n,) but for a few; infinite where they are not positive."""
    known = values[np.isfinite(values)]
    if len(known) <= TOPMOST:
        return np.inf
    top = float(np.partition(known, -TOPMOST - 1)[-TOPMOST - 1])
    return top if top > 0.0 else np.inf


def _plateau(
    readings: np.ndarray, predicted: np.ndarray, channel: int, side: float, limit: float
) -> Plateau | None:
    """The plateau of a channel at a limit, if its readings have one there."""
    read, expected = side * readings[:, channel], side * predicted[:, channel]
    known = np.isfinite(read) & np.isfinite(expected)
    read, expected = read[known], expected[known]
    approach = (expected > APPROACH * limit) & (expected < (1.0 - NEAR) * limit)
    if approach.sum() < MIN_APPROACH:
        return None
    missed = float(np.sqrt(np.mean((read - expected)[approach] ** 2)))
    beyond = expected > min(BEYOND * limit, limit + REACH * missed)
    if beyond.sum() < MIN_BEYOND:
        return None
    level = float(np.median(read[beyond]))
    low, high = np.quantile(read[beyond], TRIMMED)
    scatter = float(high - low) / 3.29
    passed = float(np.quantile(expected[beyond], TRIMMED[1])) - level
    if scatter > MAX_SCATTER * limit or passed < REACH * max(scatter, missed):
        return None
    if not _mostly_beyond(read, beyond, level, scatter):
        return None
    lost = float(np.median((expected - read)[beyond]))
    abrupt = REACH * scatter < lost and _abrupt(read, expected, beyond, level - 2.0 * missed)
    if not (abrupt or _flat(read, expected, beyond, approach)):
        return None
    noise = float(np.std(np.diff((read - expected)[approach]))) / np.sqrt(2.0)
    return Plateau(channel, side, level, scatter, noise, int(beyond.sum()))


def _mostly_beyond(read: np.ndarray, beyond: np.ndarray, level: float, scatter: float) -> bool:
    """Whether what reads a limit is predicted beyond it.

    Of a motion that dwells at its highest rate an encoder's noise predicts a few readings beyond,
    and they alone would look as if they stood still.
    """
    there = read >= level - scatter
    return int((there & beyond).sum()) >= MOSTLY * int(there.sum())


def _flat(read: np.ndarray, expected: np.ndarray, beyond: np.ndarray, approach: np.ndarray) -> bool:
    """Whether readings beyond a limit follow the prediction no more, or have lost their noise."""
    off = expected[beyond] - expected[beyond].mean()
    slope = float(off @ read[beyond]) / max(float(off @ off), 1e-300)
    noise = (read - expected)[approach]
    if np.ptp(expected[beyond]) > REACH * 3.0 * float(np.std(noise)):
        return abs(slope) < FLAT
    return float(np.std(read[beyond])) < QUIET * float(np.std(noise))


def _abrupt(read: np.ndarray, expected: np.ndarray, beyond: np.ndarray, level: float) -> bool:
    """Whether readings that follow the prediction up to a level fall short of it beyond.

    A unit at rest reaches a limit in one position alone, where no slope is to be seen.
    """
    short = expected - read
    below = (expected > BELOW * level) & (expected < level)
    if below.sum() < MIN_BEYOND:
        return False
    return abs(float(short[below].mean())) < LOST_BELOW * float(np.median(short[beyond]))
