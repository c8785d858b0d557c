"""A scale factor that bends at one end of the range only: clipping as deep as the noise.

No plateau shows there, since noise hides it; what polynomials fit to it bends nowhere else.
"""

import numpy as np

from tasks.model.term import Inputs
from tasks.motion.whole import Motion

CLIPPING = {
    "accel_nonlinearity": "accel_saturation",
    "gyro_scale_nonlinearity": "gyro_saturation",
}
END = 0.1  # of the range of a channel's input
MOSTLY = 0.7  # of the bend's power at one end: a parabola over an even input has a quarter there


def bends_at_one_end(effect: str, contribution: np.ndarray, motion: Motion) -> tuple[str, ...]:
    """The name of clipping, if an effect bends a scale factor nearly at one end alone.

    contribution: (n, 6) rad/s and m/s² that it adds to the readings; the channel that it changes
    most, in units of its own range, decides.
    """
    if effect not in CLIPPING:
        return ()
    inputs = Inputs.of(motion)
    felt = np.hstack([inputs.rate, inputs.force])
    powers = np.array([_bend(felt[:, c], contribution[:, c]) for c in range(felt.shape[1])])
    total, at_end = powers[int(np.argmax(powers[:, 0]))]
    return (CLIPPING[effect],) if at_end > MOSTLY * total > 0.0 else ()


def _bend(own: np.ndarray, added: np.ndarray) -> tuple[float, float]:
    """Power that no straight line takes of what is added (n,) to an input (n,), in units of the
    input's range; and how much of it lies at one end.
    """
    known = np.isfinite(own) & np.isfinite(added)
    own, added = own[known], added[known]
    size = float(np.ptp(own)) if len(own) else 0.0
    if not size > 0.0 or not added.any():
        return 0.0, 0.0
    place = (own - own.min()) / size
    line = np.polynomial.polynomial.polyfit(place, added / size, 1)
    power = (added / size - np.polynomial.polynomial.polyval(place, line)) ** 2
    ends = (float(power[side].sum()) for side in (place < END, place > 1.0 - END))
    return float(power.sum()), max(ends)
