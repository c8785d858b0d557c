"""Oscillating transients above the noise: their starting times and frequencies.

Power of exponentially fading windows, at every frequency, over its median in the same motion
state. A step or a peak has more beside its frequency than an oscillation has.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.stats import gamma

from tasks.explain.events.noise import RATE_CHANGE, equalised, median_by_state, motion_states
from tasks.motion.whole import Motion

DECAYS = (0.3, 0.9, 2.7)  # s, that are tried
SLOWEST, FASTEST = 0.6, 10.0  # Hz
WINDOW, PADDED = 3.0, 8.0  # decays that a window lasts, and with the zeros after it
MAX_FILLED = 12  # decays that an oscillation may fill
HOPS = 4  # windows that start within a decay
BESIDE = 4  # bins from a peak
MAX_BESIDE = 0.5  # of its power: what an oscillation may have there


@dataclass(frozen=True)
class Transient:
    """start: s. frequency: Hz. decay: s. power: over the noise, gamma distributed without one."""

    start: float
    frequency: float
    decay: float
    power: float


def find_transients(
    t: np.ndarray, white: np.ndarray, motion: Motion, false_alarm: float
) -> tuple[list[Transient], int]:
    """Transients in white readings (m, k) at even times t (m,) s, strongest first, apart in time.

    With them the number of windows and frequencies that were searched.
    """
    spectra = [(decay, *_peak_power(t, white, motion, decay)) for decay in DECAYS]
    searched = sum(power.size for _, _, _, power in spectra)
    threshold = float(gamma.isf(false_alarm / max(searched, 1), white.shape[1]))
    found = [
        Transient(float(starts[row]), float(frequencies[k]), decay, float(power[row, k]))
        for decay, starts, frequencies, power in spectra
        for row, k in zip(*np.nonzero(power > threshold), strict=True)
    ]
    apart: list[Transient] = []
    for new in sorted(found, key=lambda each: -each.power):
        if all(abs(new.start - each.start) > 2 * max(new.decay, each.decay) for each in apart):
            apart.append(new)
    return apart, searched


def _peak_power(
    t: np.ndarray, white: np.ndarray, motion: Motion, decay: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Starts (w,) s, frequencies (k,) Hz and the power (w, k) of peaks, 0 where there is none."""
    step = float(np.median(np.diff(t)))
    length, hop = int(WINDOW * decay / step), max(1, round(decay / step / HOPS))
    if len(t) < 4 * length:
        return np.zeros(0), np.zeros(0), np.zeros((0, 0))
    fading = np.exp(-np.arange(length) * step / decay).astype(np.float32)
    size = next_fast_len(int(PADDED * decay / step), real=True)
    frequencies = np.fft.rfftfreq(size, step)
    reach = int(np.searchsorted(frequencies, min(FASTEST, 0.4 / step)))
    starts = np.arange(0, len(t) - length, hop)
    state = motion_states(motion, t[starts])
    total = np.zeros((len(starts), reach), np.float32)
    for channel in white.astype(np.float32).T:  # half the work, and exact enough
        windows = np.lib.stride_tricks.sliding_window_view(channel, length)[starts]
        transform = rfft(windows * fading, size)[:, :reach]
        power = transform.real**2 + transform.imag**2
        level = median_by_state(power, state) / np.float32(np.log(2))
        total += np.divide(power, level, out=np.zeros_like(power), where=level > 0)
    total = equalised(total, state, MAX_FILLED * HOPS)
    inner = total[:, BESIDE:-BESIDE]
    beside = np.maximum(total[:, : -2 * BESIDE], total[:, 2 * BESIDE :])
    slow = frequencies[BESIDE : reach - BESIDE] < SLOWEST
    # What starts while the rate changes may be left of the motion itself.
    even = (state != RATE_CHANGE)[:, None]
    peaks = np.where(even & ~slow & (beside < MAX_BESIDE * inner), inner, 0.0)
    return t[starts], frequencies[BESIDE : reach - BESIDE], peaks
