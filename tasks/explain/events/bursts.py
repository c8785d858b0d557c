"""Bursts: damped oscillations of one frequency and decay that start at irregular times.

Oscillating transients above the noise: their starting times and frequencies.

Power of exponentially fading windows, at every frequency, over its median in the same motion
state. A step or a peak has more beside its frequency than an oscillation has.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.signal import correlate
from scipy.stats import gamma

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import AddedSignal, channel_names
from tasks.explain.events.noise import RATE_CHANGE, equalised, median_by_state, motion_states
from tasks.explain.events.residual import Residual, peak_offset
from tasks.explain.events.ringing import LIFETIME, Aligned, Ringing, damped_wave
from tasks.motion.samples import in_blocks
from tasks.words import message

BLOCK_RATE = 25.0  # Hz, of the means that bursts are looked for in
FALSE_ALARM = 1e-6  # its trials are not quite counted: waves, decays and starts are correlated
SIGNIFICANT = 5.0  # of the noise: a further burst of a known wave
MEDIAN_CHI2 = 0.4549  # of one degree of freedom
RELATIVE_SIZE = (0.5, 2.0)  # of a further burst, over that of the known one
MIN_ROWS = 100
MAX_BURSTS = 60  # more are no odd events
MAX_ROUNDS = 3
MAX_DECAY = 8.0  # s
MAX_TIMES = 8  # that are listed
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


def find_bursts(residual: Residual, start: float = 0.0) -> AddedSignal | None:
    """Bursts in a residual; start: of t = 0 on the recording's own clock, s."""
    if len(residual.t) < MIN_ROWS:
        return None
    blocks = _block_means(residual)
    channels = np.flatnonzero(blocks.weight.any(axis=0))
    if len(channels) == 0:
        return None
    white = blocks.white[:, channels]
    strong, searched = find_transients(blocks, white)
    if not strong or len(strong) > MAX_BURSTS:
        return None
    state = motion_states(blocks.motion, blocks.t)
    fit = _all_alike(blocks, state, strong[0])
    if len(fit.starts) > MAX_BURSTS or fit.decay > MAX_DECAY or _at_changes(blocks, state, fit):
        return None
    p_value = min(1.0, searched * float(gamma.sf(strong[0].power, len(channels))))
    count = len(fit.starts)
    times = ", ".join(f"{start + each:.0f}" for each in fit.starts[:MAX_TIMES])
    times += ", …" if count > MAX_TIMES else ""
    description = message(
        "events-bursts", count=count, frequency=f"{fit.frequency:.3g}", decay=f"{fit.decay:.2g}",
        channels=channel_names(fit.channels), times=times,
    )  # fmt: skip
    number = FoundParameter(name="bursts", value=float(count), unit="1", u=0.0)
    # Cramér and Rao: the decay rate of a fading wave is known to √(2/gain) of it.
    return fit.event(number, float(np.sqrt(2 / fit.gain.sum())), p_value, description)


def _block_means(residual: Residual) -> Residual:
    """Means of so many rows as make up a block; gaps in the stamps are passed over."""
    rows = max(1, round(1 / (BLOCK_RATE * residual.interval)))
    squares = residual.weight**2
    information, weighted = (
        in_blocks(values, rows).sum(axis=1) for values in (squares, residual.values * squares)
    )
    means = np.divide(weighted, information, out=np.zeros_like(weighted), where=information > 0)
    middle = in_blocks(residual.t, rows).mean(axis=1)
    return replace(residual, t=middle, values=means, weight=np.sqrt(information))


def _at_changes(blocks: Residual, state: np.ndarray, fit: Ringing) -> bool:
    """Whether bursts occur where the rate changes: a residual of the motion there is not a
    burst.
    """
    states = state[np.searchsorted(blocks.t, fit.starts).clip(0, len(state) - 1)]
    even = float((state != RATE_CHANGE).mean())
    return bool((states != RATE_CHANGE).sum() < 0.5 * even * len(states))


def _all_alike(blocks: Residual, state: np.ndarray, strongest: Transient) -> Ringing:
    """All bursts with the shape of the strongest transient, then with their common shape."""
    frequencies = strongest.frequency * np.array([0.95, 1.0, 1.05])
    decays = strongest.decay * np.array([0.5, 0.8, 1.2, 1.8])
    fit = _fit(blocks, np.array([strongest.start]), frequencies, decays)
    for _ in range(MAX_ROUNDS):
        starts = _matched_starts(blocks, state, fit)
        if not 0 < len(starts) <= MAX_BURSTS:
            break
        fit = _fit(blocks, starts, np.array([fit.frequency]), np.array([fit.decay]))
    return fit


def _fit(
    blocks: Residual, starts: np.ndarray, frequencies: np.ndarray, decays: np.ndarray
) -> Ringing:
    """Shape and amplitude that bursts with these starts have in common."""
    part = Aligned.after(starts, blocks, LIFETIME * float(decays.max()))
    shape = part.shape(frequencies, decays)
    return Ringing(starts, *part.amplitude(*shape), *shape)


def _matched_starts(blocks: Residual, state: np.ndarray, fit: Ringing) -> np.ndarray:
    """Starts (m,) s of all bursts of a shape by its matched filter, to a fraction of a block."""
    step = blocks.interval
    age = np.arange(int(LIFETIME * fit.decay / step)) * step
    template = (fit.amplitude * damped_wave(age, fit.frequency, fit.decay)[:, None]).real
    squares = blocks.weight**2
    matched, information = np.zeros(len(blocks.t)), np.zeros(len(blocks.t))
    for c in range(6):
        matched += _correlated(blocks.values[:, c] * squares[:, c], template[:, c])
        information += _correlated(squares[:, c], template[:, c] ** 2)
    information = np.maximum(information, 1e-30)
    size, deviate = matched / information, matched / np.sqrt(information)
    power = (deviate**2)[:, None]
    level = np.maximum(median_by_state(power, state) / MEDIAN_CHI2, 1.0)
    power = equalised(power / level, state, int(MAX_FILLED * fit.decay / step))
    deviate = np.sign(deviate) * np.sqrt(power[:, 0])
    alike = (size > RELATIVE_SIZE[0]) & (size < RELATIVE_SIZE[1])
    likely = np.where(alike, deviate, 0.0)
    likely[-max(1, int(fit.decay / step)) :] = 0.0  # too little is left of it there
    starts: list[float] = []
    while likely.max() > SIGNIFICANT and len(starts) <= MAX_BURSTS:
        top = int(likely.argmax())
        starts.append(blocks.t[top] + step * peak_offset(deviate, top))
        likely[np.abs(blocks.t - blocks.t[top]) < 2 * fit.decay] = 0.0
    return np.sort(starts)


def _correlated(values: np.ndarray, template: np.ndarray) -> np.ndarray:
    """Σ values[k + j]·template[j], (m,), for each start k."""
    padded = np.concatenate([values, np.zeros(len(template) - 1)])
    return np.asarray(correlate(padded, template, mode="valid", method="fft"))


def find_transients(blocks: Residual, white: np.ndarray) -> tuple[list[Transient], int]:
    """Transients in some white channels (m, k) of blocks, strongest first, apart in time.

    With them the number of windows and frequencies that were searched.
    """
    spectra = [(decay, *_peak_power(blocks, white, decay)) for decay in DECAYS]
    searched = sum(power.size for _, _, _, power in spectra)
    threshold = float(gamma.isf(FALSE_ALARM / max(searched, 1), white.shape[1]))
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
    blocks: Residual, white: np.ndarray, decay: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Starts (w,) s, frequencies (k,) Hz and the power (w, k) of peaks, 0 where there is none."""
    t, step = blocks.t, blocks.interval
    length, hop = int(WINDOW * decay / step), max(1, round(decay / step / HOPS))
    if len(t) < 4 * length:
        return np.zeros(0), np.zeros(0), np.zeros((0, 0))
    fading = np.exp(-np.arange(length) * step / decay).astype(np.float32)
    size = next_fast_len(int(PADDED * decay / step), real=True)
    frequencies = np.fft.rfftfreq(size, step)
    reach = int(np.searchsorted(frequencies, min(FASTEST, 0.4 / step)))
    starts = np.arange(0, len(t) - length, hop)
    state = motion_states(blocks.motion, t[starts])
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
