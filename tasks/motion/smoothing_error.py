"""What smoothing the angles of encoders takes from their acceleration.

A window as long as a coarse encoder needs rounds off the ramps of a table, and what follows the
angular acceleration, as a lever arm does, is found too large by as much. How much it takes, the
smoothed acceleration tells when it is smoothed again.
"""

import numpy as np

from schemas.recording import Recording
from tasks.motion.encoder_rate import filtered
from tasks.motion.smooth import smooth_course


def lost_acceleration(recording: Recording, t: np.ndarray) -> np.ndarray:
    """(n, k) rad/s² that a second smoothing takes from the accelerations of a table's k axes.

    t: (n,) s of the recording. Zero where nothing is known.
    """
    axes = recording.manifest.station.table_axes or ()
    table = recording.table
    course = table and smooth_course(table, tuple(f"{axis.name}_angle" for axis in axes))
    if not course:
        return np.zeros((len(t), len(axes)))
    lost = course.acceleration - filtered(course.acceleration, _mean_kernel(course.half))
    return np.column_stack([np.interp(t, course.even, column) for column in lost.T])


def _mean_kernel(half: int) -> np.ndarray:
    """The weighted mean (2·half − 1,) of second differences that a fitted parabola's bend is."""
    j = np.arange(-half, half + 1.0)
    centred = j**2 - (j**2).mean()
    bend = 2.0 * centred / (centred**2).sum()
    return np.cumsum(np.cumsum(bend))[: 2 * half - 1]
