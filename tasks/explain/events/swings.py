"""Swings that stand out from what is left elsewhere: where they start, how fast they swing.

Power of exponentially fading windows, at every frequency, over its median wherever the motion is
alike. A step or a peak has more beside its frequency than a swing has.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.stats import gamma

from tasks.explain.events.regimes import CHANGES, levels, regimes_at, without_louder
from tasks.motion.whole import Motion

DECAYS = (0.3, 0.9, 2.7)  # s, that are tried
SLOWEST, FASTEST = 0.6, 10.0  # Hz
LONG, PADDED = 3.0, 8.0  # decays that a window lasts, and with the zeros after it
FILLED = 12  # decays that a swing may fill
HOPS = 4  # windows that start within a decay
BESIDE = 4  # bins from a peak
PEAKED = 0.5  # of its power: what a swing may have there


@dataclass(frozen=True)
class Swing:
    """start: s. frequency: Hz. decay: s. power: over the noise, gamma distributed without one."""

    start: float
    frequency: float
    decay: float
    power: float


def standing_out(
    t: np.ndarray, white: np.ndarray, motion: Motion, false_alarm: float
) -> tuple[list[Swing], int]:
    """Swings in white readings (m, k) at even times t (m,) s, strongest first, apart in time.

    With them how many windows and frequencies were looked at.
    """
    seen, looked = list[tuple[float, Swing]](), 0
    powers = [(decay, *_powers(t, white, motion, decay)) for decay in DECAYS]
    looked = sum(power.size for _, _, _, power in powers)
    threshold = float(gamma.isf(false_alarm / max(looked, 1), white.shape[1]))
    for decay, starts, frequencies, power in powers:
        for row, column in zip(*np.nonzero(power > threshold), strict=True):
            swing = Swing(
                float(starts[row]), float(frequencies[column]), decay, float(power[row, column])
            )
            seen.append((-swing.power, swing))
    seen.sort(key=lambda pair: pair[0])
    apart: list[Swing] = []
    for _, swing in seen:
        if all(abs(swing.start - each.start) > 2 * max(swing.decay, each.decay) for each in apart):
            apart.append(swing)
    return apart, looked


def _powers(
    t: np.ndarray, white: np.ndarray, motion: Motion, decay: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Starts (w,) s, frequencies (k,) Hz and the power (w, k) of peaks, 0 where there is none."""
    step = float(np.median(np.diff(t)))
    length, hop = int(LONG * decay / step), max(1, round(decay / step / HOPS))
    if len(t) < 4 * length:
        return np.zeros(0), np.zeros(0), np.zeros((0, 0))
    fading = np.exp(-np.arange(length) * step / decay).astype(np.float32)
    size = next_fast_len(int(PADDED * decay / step), real=True)
    frequencies = np.fft.rfftfreq(size, step)
    reach = int(np.searchsorted(frequencies, min(FASTEST, 0.4 / step)))
    starts = np.arange(0, len(t) - length, hop)
    regime = regimes_at(motion, t[starts])
    total = np.zeros((len(starts), reach), np.float32)
    for channel in white.astype(np.float32).T:  # half the work, and exact enough
        cut = np.lib.stride_tricks.sliding_window_view(channel, length)[starts]
        heard = rfft(cut * fading, size)[:, :reach]
        power = heard.real**2 + heard.imag**2
        level = levels(power, regime) / np.float32(np.log(2))
        total += np.divide(power, level, out=np.zeros_like(power), where=level > 0)
    total = without_louder(total, regime, FILLED * HOPS)
    inner = total[:, BESIDE:-BESIDE]
    beside = np.maximum(total[:, : -2 * BESIDE], total[:, 2 * BESIDE :])
    slow = frequencies[BESIDE : reach - BESIDE] < SLOWEST
    # What starts while the rate changes may be left of the motion itself.
    even = (regime != CHANGES)[:, None]
    peaks = np.where(even & ~slow & (beside < PEAKED * inner), inner, 0.0)
    return t[starts], frequencies[BESIDE : reach - BESIDE], peaks
