"""What a run with a single size of rate cannot tell from a scale factor that bends: clipping.

A reading that is clipped short of the only rate is too small there, and right everywhere below; so
is that of a scale factor with a curvature. Rates between rest and the only one are in ramps alone.
"""

import numpy as np

from tasks.motion.whole import Motion

BENDING = ("gyro_scale_nonlinearity", "gyro_scale_asymmetry")
CLIPPING = "gyro_saturation"
SLOW = 0.3  # of the largest rate about an axis: slower ones show neither
HELD = 0.05  # of the largest rate in a second: what changes less is held
ALIKE = 0.05  # relative: rates that differ by less are of one size
NEARLY_ALL = 0.9


def possibly_clipped(effect: str, channels: tuple[int, ...], motion: Motion) -> tuple[str, ...]:
    """The name of clipping, if an effect bends the scale factor of channels (0 to 5) that turned at
    one size of rate only; nothing otherwise.
    """
    gyros = [channel for channel in channels if channel < 3]
    if effect not in BENDING or not gyros:
        return ()
    return (CLIPPING,) if all(_one_size(motion, axis) for axis in gyros) else ()


def _one_size(motion: Motion, axis: int) -> bool:
    """Whether an axis was held at one size of rate, to either side, or at slow ones."""
    rate = np.abs(np.nan_to_num(motion.rate[:, axis]))
    turning = rate > SLOW * rate.max(initial=0.0)
    if not turning.any():
        return False
    size = float(np.median(rate[turning]))
    held = turning & (np.abs(np.nan_to_num(motion.acceleration[:, axis])) < HELD * size)
    if 2 * held.sum() < turning.sum():
        return False  # never held, as by hand
    return bool(np.mean(np.abs(rate[held] - size) < ALIKE * size) > NEARLY_ALL)
