"""The standard's model fitted to whole samples by ordinary least squares, channel by channel.

Every sample counts the same. It is the prediction that events and sample noise are read off
before anything is known of the noise; `tasks.model.fit` weights by the noise.
"""

import numpy as np

from tasks.model.parameters import ACCEL_FIRST
from tasks.model.regression import inverse
from tasks.model.simulate import CHANNEL_COUNT
from tasks.model.terms.standard import regressors
from tasks.motion.whole import Motion

MAX_FIT_ROWS = 400_000  # evenly spread; more rows would not change a prediction by its noise


def plain_prediction(
    readings: np.ndarray,
    motion: Motion,
    masked: np.ndarray | None = None,
    *,
    own_squared_rate: bool = False,
) -> np.ndarray:
    """What the standard's model predicts (n, 6), fitted to the readings (n, 6) rad/s, m/s².

    masked: (n, 6) bool, readings that the fit does not use; nor does it use NaN. The prediction is
    NaN where the motion is not known, and in a channel without a reading to fit. own_squared_rate:
    an accelerometer follows ω² of its own axis, too, which the standard leaves out; noise that is
    read off the residual then holds none of it.
    """
    predicted = np.full(readings.shape, np.nan)
    rows = slice(None, None, len(readings) // MAX_FIT_ROWS + 1)
    for channel in range(CHANNEL_COUNT):
        used = motion.felt[rows, channel] & np.isfinite(readings[rows, channel])
        if masked is not None:
            used &= ~masked[rows, channel]
        if not used.any():
            continue
        columns = regressors(motion, channel)
        if own_squared_rate and channel >= ACCEL_FIRST:
            columns = np.column_stack([columns, motion.rate[:, channel - ACCEL_FIRST] ** 2])
        design = columns[rows][used]
        right = design.T @ readings[rows, channel][used]
        fitted = columns @ (inverse(design.T @ design) @ right)
        predicted[:, channel] = np.where(motion.felt[:, channel], fitted, np.nan)
    return predicted
