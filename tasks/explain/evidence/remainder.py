"""The remainder when nothing was found: a finding without a name, so that it is looked into."""

import numpy as np
from scipy.signal import welch

from tasks.explain.evidence.left_over import LeftOver, block_means_at_rows
from tasks.explain.explanation import UNNAMED, Finding
from tasks.explain.inputs.full_rate import FullRate
from tasks.words import message
from tasks.words.quantities import percent, plain

CLEAR = 2.0  # chi-squared per degree of freedom from which a channel is told of
REFERENCE_KNOWN = 10.0  # times its own account: the power that a reference's noise may have
BAND = (0.1, 0.9)  # quantiles of the power above noise between which a band is told
WINDOW = 20.0  # s of one spectrum


def remainder(full: FullRate, found: np.ndarray, left: LeftOver) -> Finding | None:
    """The residual above the noise as one finding; None if it may be the reference's errors.

    found: (n, 6) predicted readings. It removes nothing and adds nothing to the readings.
    """
    clear = left.beyond_reference(REFERENCE_KNOWN) >= CLEAR
    channels = tuple(np.flatnonzero(clear).tolist())
    if not channels:
        return None
    low, high = band_of(full, found, left, channels)
    return Finding(
        effect=UNNAMED,
        family=UNNAMED,
        title=message("explain-remainder", share=percent(1.0 - left.explained_share),
                      low=plain(low, 2), high=plain(high, 2)),
        equation="",
        source="",
        channels=channels,
        parameters=(),
        contribution=np.zeros_like(found),
        gain=0.0,
        delta_bic=0.0,
        held_out_gain=0.0,
        remainder=True,
    )  # fmt: skip


def band_of(
    full: FullRate, found: np.ndarray, left: LeftOver, channels: tuple[int, ...]
) -> tuple[float, float]:
    """The frequencies (Hz) between which four fifths of the power above noise lie."""
    residual = np.where(left.masked, np.nan, full.readings - found) / np.sqrt(
        left.noise * left.rows
    )
    means = block_means_at_rows(residual, left.rows)[:: left.rows, list(channels)]
    interval = full.motion.interval * left.rows
    frequency, power = welch(
        np.nan_to_num(means), 1.0 / interval, nperseg=min(len(means), round(WINDOW / interval)),
        axis=0,
    )  # fmt: skip
    noise = 2.0 * interval / left.rows
    above = np.maximum.accumulate(np.cumsum(power[1:].sum(axis=1) - noise * len(channels)))
    low, high = np.searchsorted(above, above[-1] * np.array(BAND))
    return float(frequency[1:][low]), float(frequency[1:][high])
