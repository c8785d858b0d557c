"""Readings that settle as a recording begins, or are torn as it ends.

Loggers begin with an empty row and filters with empty memories: a few readings far from all others,
which a fit of everything else would be bent by. They are sought beside the prediction of a fit
without the ends, so that they need not be alone to stand out.
"""

import numpy as np

from tasks.explain.events.event import channel_names
from tasks.model.fit import plain_prediction
from tasks.motion.whole import Motion
from tasks.words import Message, message

LONGEST_S, LONGEST = 2.0, 0.02  # s, and of the recording: an end that is longer is no end
USUAL = 0.999  # of the other residuals are smaller
BEYOND = 3.0  # times that: an end that stands out


def find_settling(readings: np.ndarray, motion: Motion) -> tuple[np.ndarray, tuple[Message, ...]]:
    """Which readings (n, 6) bool at the ends say nothing, and remarks on them.

    readings: (n, 6) rad/s and m/s². An end is twice as long as readings of one channel stand out,
    and of all: a filter's go on settling when they no longer do, or follow a motion that begins.
    """
    count, length = len(readings), 0
    if motion.interval > 0.0:
        length = int(min(LONGEST_S / motion.interval, LONGEST * count))
    masked = np.zeros(readings.shape, bool)
    if not length:
        return masked, ()
    ends = np.zeros(readings.shape, bool)
    ends[:length] = ends[-length:] = True
    residual = np.abs(readings - plain_prediction(readings, motion, ends))
    remarks: list[Message] = []
    for rows, name in ((slice(0, length), "start"), (slice(-1, -length - 1, -1), "end")):
        settled = _settled_after(residual[rows], residual[length:-length])
        if not settled.any():
            continue
        masked[rows] |= np.arange(length)[:, None] < 2 * settled.max()
        channels = channel_names(tuple(np.flatnonzero(settled).tolist()))
        seconds = f"{2.0 * settled.max() * motion.interval:.3g}"
        remarks.append(message(f"events-settling-{name}", channels=channels, seconds=seconds))
    return masked, tuple(remarks)


def _settled_after(end: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(6,) number of rows from the outermost in which a channel's residual stands out.

    end: (rows, 6) sizes, the outermost first; others: (n, 6). None where the end itself is not
    known, and none where it stands out as far as it is looked at.
    """
    settled = np.zeros(end.shape[1], int)
    for channel, sizes in enumerate(others.T):
        known = sizes[np.isfinite(sizes)]
        usual = float(np.quantile(known, USUAL)) if len(known) else 0.0
        far = end[:, channel] > BEYOND * usual
        if usual and far[0]:
            settled[channel] = np.flatnonzero(far)[-1] + 1
    return np.where(2 * settled <= len(end), settled, 0)
