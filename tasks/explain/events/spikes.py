"""Spikes: single readings far off, which nothing in the catalogue names."""

import numpy as np
from scipy.stats import norm

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import Event, named
from tasks.motion.whole import Motion

FEWEST_SPIKES = 3
LARGE = 7.0  # of the noise: a reading that stands out so far from both its neighbours
CORNER = 10  # rows
STEADY = 0.02  # rad/s: how far the rate may move where it counts as steady


def find_spikes(
    residual: np.ndarray, noise: np.ndarray, motion: Motion
) -> tuple[Event | None, np.ndarray]:
    """Single readings far from both their neighbours, and which (n, 6) bool they are."""
    white = np.divide(residual, noise, out=np.full(residual.shape, np.nan), where=noise > 0)
    apart = np.zeros(residual.shape)
    apart[1:-1] = (white[1:-1] - 0.5 * (white[:-2] + white[2:])) / np.sqrt(1.5)
    far = (np.abs(apart) > LARGE) & _calm(motion.rate)[:, None]
    # A neighbour of a spike is far off as well, by less.
    peak = np.zeros(far.shape, bool)
    size = np.where(far, np.abs(apart), 0.0)
    peak[1:-1] = far[1:-1] & (size[1:-1] >= size[:-2]) & (size[1:-1] >= size[2:])
    at_rest = np.linalg.norm(motion.rate, axis=1) < STEADY
    rows: np.ndarray = np.asarray(peak.any(axis=1))
    spread = _spread(far)
    if rows.sum() < FEWEST_SPIKES:
        return None, spread
    channels = tuple(np.flatnonzero(peak.any(axis=0)).tolist())
    count = int(rows.sum())
    expected = far.size * 2 * norm.sf(LARGE)
    english, chinese = named(channels)
    turning = bool(at_rest.mean() > 0.05 and not (rows & at_rest).any())
    said = (
        f"{count} single readings stand out from their neighbours by more than {LARGE:.0f} times "
        f"the noise, in the {english}" + (", only while the table turns" if turning else ""),
        f"{count} 个孤立读数偏离相邻读数超过噪声的 {LARGE:.0f} 倍，通道：{chinese}"
        + ("，仅在转台转动时出现" if turning else ""),
    )
    parameters = (FoundParameter(name="spikes", value=float(count), unit="1", u=0.0),)
    p_value = float(min(1.0, expected**FEWEST_SPIKES))
    return Event("unnamed", channels, parameters, p_value, said, rows), spread


def _calm(rate: np.ndarray) -> np.ndarray:
    """Rows (n,) bool about which the rate does not change: a corner of a ramp is no spike."""
    calm = np.zeros(len(rate), bool)
    inside = slice(CORNER, -CORNER)
    change = np.abs(rate[2 * CORNER :] - rate[: -2 * CORNER]).max(axis=1, initial=0.0)
    calm[inside] = change < STEADY
    changes = np.convolve((~calm).astype(float), np.ones(2 * CORNER + 1), "same") > 0.5
    return ~changes


def _spread(far: np.ndarray) -> np.ndarray:
    """Rows that stand out and those beside them."""
    near = far.copy()
    near[1:] |= far[:-1]
    near[:-1] |= far[1:]
    return near
