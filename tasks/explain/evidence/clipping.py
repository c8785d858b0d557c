"""Clipping that a run cannot tell from a scale factor that bends.

A reading that is clipped short of the only rate is too small there, and right everywhere below; so
is that of a scale factor with a curvature. Rates between rest and the only one are in ramps alone.

Clipping as deep as the noise shows in no plateau. It bends a scale factor at one end of the range
alone, and cuts off the noise there; where a unit rests in a few positions any bend may lie at one
end, and the noise alone tells.
"""

from collections.abc import Iterator

import numpy as np

from tasks.explain.events.saturation import EFFECTS as LIMITS
from tasks.model.effect import EVENTS
from tasks.model.term import Inputs
from tasks.model.terms.gyro import GYRO_SCALE_ASYMMETRY
from tasks.motion.whole import Motion

CLIPPING = {bend: limit for limit in LIMITS for bend in EVENTS[limit].confused_with}
GYRO_CLIPPING = LIMITS[0]
BENDING = (*EVENTS[GYRO_CLIPPING].confused_with, GYRO_SCALE_ASYMMETRY.name)
SLOW_RATE = 0.3  # of the largest rate about an axis: slower ones show neither
HELD = 0.05  # of the largest rate in a second: what changes less is held
ALIKE = 0.05  # relative: rates that differ by less are of one size
NEARLY_ALL = 0.9
END = 0.1  # of the range of a channel's input
MOSTLY = 0.7  # of the bend's power at one end: a parabola over an even input has a quarter there
RESTING = 0.05  # rad/s: what turns faster may vibrate
FEWEST = 200  # readings at rest by whose scatter noise is compared
CUT = 0.9  # of the noise elsewhere: a hundredth is what chance makes


def possibly_clipped(effect: str, channels: tuple[int, ...], motion: Motion) -> tuple[str, ...]:
    """The name of clipping, if an effect bends the scale factor of channels (0 to 5) that turned at
    one size of rate only; nothing otherwise.
    """
    gyros = [channel for channel in channels if channel < 3]
    if effect not in BENDING or not gyros:
        return ()
    return (GYRO_CLIPPING,) if all(_one_size(motion, axis) for axis in gyros) else ()


def _one_size(motion: Motion, axis: int) -> bool:
    """Whether an axis was held at one size of rate, to either side, or at slow ones."""
    rate = np.abs(np.nan_to_num(motion.rate[:, axis]))
    turning = rate > SLOW_RATE * rate.max(initial=0.0)
    if not turning.any():
        return False
    size = float(np.median(rate[turning]))
    held = turning & (np.abs(np.nan_to_num(motion.acceleration[:, axis])) < HELD * size)
    if 2 * held.sum() < turning.sum():
        return False  # never held, as by hand
    return bool(np.mean(np.abs(rate[held] - size) < ALIKE * size) > NEARLY_ALL)


def possibly_clipped_in_noise(
    effect: str, contribution: np.ndarray, readings: np.ndarray, motion: Motion
) -> tuple[str, ...]:
    """The name of clipping, if an effect bends a scale factor at one end or noise is cut there.

    contribution, readings: (n, 6) rad/s and m/s², what the effect adds to the readings, and they.
    The channel that it changes most, in units of its own range, tells where it bends.
    """
    if effect not in CLIPPING:
        return ()
    inputs = Inputs.of(motion)
    felt = np.hstack([inputs.rate, inputs.force])
    channels = [c for c in range(felt.shape[1]) if np.nan_to_num(contribution[:, c]).any()]
    bends = [_bend(felt[:, c], contribution[:, c]) for c in channels]
    total, at_end = max(bends, default=(0.0, 0.0))
    resting = np.linalg.norm(np.nan_to_num(motion.rate), axis=1) < RESTING
    cut = any(_noise_is_cut(felt[:, c], readings[:, c], resting) for c in channels)
    return (CLIPPING[effect],) if cut or at_end > MOSTLY * total > 0.0 else ()


def _bend(own: np.ndarray, added: np.ndarray) -> tuple[float, float]:
    """Power that no straight line takes of what is added (n,) to an input (n,), in units of the
    input's range; and how much of it lies at one end.
    """
    known = np.isfinite(own) & np.isfinite(added)
    own, added = own[known], added[known]
    size = float(np.ptp(own)) if len(own) else 0.0
    if not size > 0.0:
        return 0.0, 0.0
    place = (own - own.min()) / size
    line = np.polynomial.polynomial.polyfit(place, added / size, 1)
    power = (added / size - np.polynomial.polynomial.polyval(place, line)) ** 2
    return float(power.sum()), max(float(power[side].sum()) for side in _ends(place))


def _noise_is_cut(own: np.ndarray, readings: np.ndarray, resting: np.ndarray) -> bool:
    """Whether readings (n,) at rest scatter less at an end of their input (n,) than within it.

    By second differences of three rows that all lie there.
    """
    known = resting & np.isfinite(own)
    if not known.any() or not np.ptp(own[known]) > 0.0:
        return False
    place = (own - own[known].min()) / np.ptp(own[known])
    scatter = np.abs(np.diff(readings, 2))

    def level(rows: np.ndarray) -> float:
        rows = rows & known
        three = rows[:-2] & rows[1:-1] & rows[2:] & np.isfinite(scatter)
        return float(scatter[three].mean()) if three.sum() >= FEWEST else np.nan

    within = level((place >= END) & (place <= 1.0 - END))
    return any(level(end) < CUT * within for end in _ends(place))


def _ends(place: np.ndarray) -> Iterator[np.ndarray]:
    yield from (place < END, place > 1.0 - END)
