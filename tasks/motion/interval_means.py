"""Motion as means over the intervals between the readings of a unit that puts out angles."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from tasks.motion.whole import Motion


def mean_motion(middle: "Motion", before: "Motion", after: "Motion", span: float) -> "Motion":
    """The motion of intervals `span` s long, by that of their middles and of both ends.

    Its rate is the mean over the interval: of encoders the angle between the ends, of anything
    else by Simpson's rule. What gives the force is the mean of both ends, as such a unit's
    accelerometers are read. Unknown where any of the three is.
    """
    if middle.axes is None or before.axes is None or after.axes is None:
        rate = (before.rate + 4.0 * middle.rate + after.rate) / 6.0
    else:
        mean = (after.axes.angles - before.axes.angles) / span
        own = np.einsum("nk,nki->ni", mean - middle.axes.speeds, middle.axes.directions)
        rate = middle.rate + own
    moved = before.translation, after.translation
    return replace(
        middle,
        up=0.5 * (before.up + after.up),
        north=0.5 * (before.north + after.north),
        rate=rate,
        translation=None if moved[0] is None or moved[1] is None else 0.5 * (moved[0] + moved[1]),
    )
