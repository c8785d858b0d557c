"""Spikes: single outlying readings without a name in the catalogue."""

import numpy as np
from scipy.ndimage import binary_dilation, maximum_filter1d
from scipy.stats import norm

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import Event, channel_names
from tasks.motion.whole import Motion
from tasks.words import message

MIN_SPIKES = 3
THRESHOLD = 7.0  # times the noise, by which a reading stands out from both its neighbours
CORNER = 10  # rows
STEADY = 0.02  # rad/s: how far the rate may move where it counts as steady
MIN_REST = 0.05  # share of the rows at rest, so that spikes may be missing there


def find_spikes(
    readings: np.ndarray, residual: np.ndarray, noise: np.ndarray, motion: Motion
) -> tuple[Event | None, np.ndarray]:
    """Single readings far from both their neighbours, and which (n, 6) bool to mask for them.

    In the readings and in what a plain fit leaves of them (n, 6): the one has the motion's corners,
    the other those of the reference's noise.
    """
    apart = np.minimum(_apart(readings, noise), _apart(residual, noise))
    far = (apart > THRESHOLD) & _steady(motion.rate)[:, None]
    masked = np.asarray(binary_dilation(far, np.ones((3, 1))))
    # A neighbour of a spike stands out as well, by less.
    size = np.where(far, apart, 0.0)
    peak = far & (size == maximum_filter1d(size, 3, axis=0, mode="constant"))
    rows = peak.any(axis=1)
    count = int(rows.sum())
    if count < MIN_SPIKES:
        return None, masked
    channels = tuple(np.flatnonzero(peak.any(axis=0)).tolist())
    at_rest = np.linalg.norm(motion.rate, axis=1) < STEADY
    turning = bool(at_rest.mean() > MIN_REST and not (rows & at_rest).any())
    description = message(
        "events-spikes-in-rotation" if turning else "events-spikes",
        count=count, threshold=f"{THRESHOLD:.0f}", channels=channel_names(channels),
    )  # fmt: skip
    parameters = (FoundParameter(name="spikes", value=float(count), unit="1", u=0.0),)
    expected = far.size * 2 * norm.sf(THRESHOLD)
    p_value = float(min(1.0, expected**MIN_SPIKES))
    return Event("unnamed", channels, parameters, p_value, description), masked


def _apart(values: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """(n, 6) times the noise by which values are off the middle of their neighbours."""
    white = np.divide(values, noise, out=np.full(values.shape, np.nan), where=noise > 0)
    apart = np.zeros(values.shape)
    apart[1:-1] = np.abs(white[1:-1] - 0.5 * (white[:-2] + white[2:])) / np.sqrt(1.5)
    return apart


def _steady(rate: np.ndarray) -> np.ndarray:
    """Rows (n,) bool about which the rate does not change: a corner of a ramp is no spike."""
    moving = np.ones(len(rate), bool)
    change = np.abs(rate[2 * CORNER :] - rate[: -2 * CORNER]).max(axis=1, initial=0.0)
    moving[CORNER:-CORNER] = ~(change < STEADY)
    return ~maximum_filter1d(moving, 2 * CORNER + 1, mode="constant")
