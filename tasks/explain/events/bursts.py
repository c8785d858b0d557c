"""Bursts: damped oscillations of one frequency and decay that start at irregular times.

Oscillating transients above the noise: their starting times and frequencies.

Power of exponentially fading windows, at every frequency, over its median in the same motion
state. A step or a peak has more beside its frequency than an oscillation has.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from scipy.fft import next_fast_len, rfft
from scipy.optimize import minimize
from scipy.signal import correlate
from scipy.stats import gamma

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import (
    RATE_CHANGE,
    AddedSignal,
    Residual,
    amplitude_parameters,
    channel_names,
    equalised,
    median_by_state,
    motion_states,
    peak_offset,
    significant_channels,
)
from tasks.model.fit import plain_prediction
from tasks.motion.samples import in_blocks
from tasks.motion.whole import Motion
from tasks.words import Message, message

# Damped oscillations from given starting times: the contribution of bursts.

BEYOND_GRID = 1.5  # times that a shape may lie beyond a grid
LIFETIME = 7.0  # decay times after which nothing is left of an oscillation
SIGNIFICANT_RINGING = 4.0  # standard uncertainties from which a channel has the oscillation


@dataclass(frozen=True)
class Ringing:
    """Oscillations of one shape: starts (m,) s, rising, one complex amplitude (6,) of them all,
    and the chi-squared (6,) that it gains.

    Each adds Re(amplitude·exp((2πi·f − 1/decay)·age)). frequency: Hz. decay: s.
    """

    starts: np.ndarray
    amplitude: np.ndarray
    gain: np.ndarray
    frequency: float
    decay: float

    @property
    def channels(self) -> tuple[int, ...]:
        """The channels in which it is significant; at least the strongest."""
        return significant_channels(self.gain, SIGNIFICANT_RINGING**2)

    def signal(self, t: np.ndarray) -> np.ndarray:
        """What the oscillations add to the readings (n, 6), in the channels that have them."""
        rung = np.zeros((len(t), 6))
        amplitude = np.where(np.isin(np.arange(6), self.channels), self.amplitude, 0.0)
        last = np.searchsorted(self.starts, t, side="right") - 1
        first = np.searchsorted(self.starts, t - LIFETIME * self.decay, side="right")
        for back in range(int((last - first).max(initial=-1)) + 1):
            rows = np.flatnonzero(last - back >= first)
            age = t[rows] - self.starts[last[rows] - back]
            rung[rows] += (amplitude * damped_wave(age, self.frequency, self.decay)[:, None]).real
        return rung

    def event(
        self, number: FoundParameter, relative_u: float, p_value: float, description: Message
    ) -> AddedSignal:
        """The event; number: of the oscillations. relative_u: of the decay time."""
        u = np.abs(self.amplitude) / np.sqrt(np.maximum(self.gain, 1e-300))
        u_frequency = relative_u / (2 * np.pi * self.decay)
        parameters = (
            number,
            FoundParameter(name="frequency", value=self.frequency, unit="Hz", u=u_frequency),
            FoundParameter(name="decay", value=self.decay, unit="s", u=relative_u * self.decay),
            *amplitude_parameters(self.channels, self.amplitude, u),
        )
        return AddedSignal(
            "unnamed", self.channels, parameters, p_value, description, (self.signal,)
        )


def damped_wave(age: np.ndarray, frequency: float, decay: float) -> np.ndarray:
    """exp((2πi·f − 1/decay)·age), complex (n,)."""
    return np.asarray(np.exp((2j * np.pi * frequency - 1 / decay) * age))


@dataclass(frozen=True)
class Aligned:
    """Rows after one of some starts: age (n,) s since then, and the values (n, 6) and weight (n, 6)
    of a residual.
    """

    age: np.ndarray
    values: np.ndarray
    weight: np.ndarray

    @classmethod
    def after(cls, starts: np.ndarray, residual: Residual, longest: float) -> Self:
        """The rows of a residual less than so long (s) after the last of the starts (m,) s."""
        last = np.searchsorted(starts, residual.t, side="right") - 1
        age = np.where(last >= 0, residual.t - starts[np.maximum(last, 0)], np.inf)
        rows = np.flatnonzero(age < longest)
        return cls(age[rows], residual.values[rows], residual.weight[rows])

    def amplitude(self, frequency: float, decay: float) -> tuple[np.ndarray, np.ndarray]:
        """Complex amplitude (6,) of oscillations of one shape, and the chi-squared it gains."""
        wave = damped_wave(self.age, frequency, decay)
        columns = np.column_stack([wave.real, -wave.imag])
        squares = self.weight**2
        right = columns.T @ (self.values * squares)  # (2, 6)
        products = np.einsum("ni,nj->nij", columns, columns).reshape(len(wave), 4)
        normal = (products.T @ squares).T.reshape(6, 2, 2)
        parts = np.einsum("cij,jc->ci", np.linalg.pinv(normal, hermitian=True), right)
        return parts[:, 0] + 1j * parts[:, 1], np.einsum("ci,ic->c", parts, right)

    def cost(self, log_shape: np.ndarray) -> float:
        """Chi-squared less what oscillations of a shape, log (frequency, decay), gain."""
        return -float(self.amplitude(*np.exp(log_shape))[1].sum())

    def shape(self, frequencies: np.ndarray, decays: np.ndarray) -> tuple[float, float]:
        """Frequency (Hz) and decay (s) that gain most, on a grid and then by a simplex search."""
        grid = [(self.cost(np.log([f, d])), f, d) for f in frequencies for d in decays]
        bounds = [
            (float(np.log(tried.min() / BEYOND_GRID)), float(np.log(tried.max() * BEYOND_GRID)))
            for tried in (frequencies, decays)
        ]
        best = minimize(self.cost, np.log(min(grid)[1:]), method="Nelder-Mead",
                        bounds=bounds,
                        options={"xatol": 1e-3, "fatol": 0.01, "maxiter": 80})  # fmt: skip
        frequency, decay = np.exp(best.x)
        return float(frequency), float(decay)


BLOCK_RATE = 25.0  # Hz, of the means that bursts are looked for in
BURST_FALSE_ALARM = (
    1e-6  # its trials are not quite counted: waves, decays and starts are correlated
)
SIGNIFICANT_BURST = 5.0  # of the noise: a further burst of a known wave
MEDIAN_CHI2 = 0.4549  # of one degree of freedom
RELATIVE_SIZE = (0.5, 2.0)  # of a further burst, over that of the known one
MIN_ROWS = 100
MAX_BURSTS = 60  # more are no odd events
MAX_ROUNDS = 3
MAX_DECAY = 8.0  # s
MAX_TIMES = 8  # that are listed
BURST_DECAYS = (0.3, 0.9, 2.7)  # s, that are tried
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
    fit = _fit_burst(blocks, np.array([strongest.start]), frequencies, decays)
    for _ in range(MAX_ROUNDS):
        starts = _matched_starts(blocks, state, fit)
        if not 0 < len(starts) <= MAX_BURSTS:
            break
        fit = _fit_burst(blocks, starts, np.array([fit.frequency]), np.array([fit.decay]))
    return fit


def _fit_burst(
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
    while likely.max() > SIGNIFICANT_BURST and len(starts) <= MAX_BURSTS:
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
    spectra = [(decay, *_peak_power(blocks, white, decay)) for decay in BURST_DECAYS]
    searched = sum(power.size for _, _, _, power in spectra)
    threshold = float(gamma.isf(BURST_FALSE_ALARM / max(searched, 1), white.shape[1]))
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


# Readings that settle as a recording begins, or are torn as it ends.
#
# Loggers begin with an empty row and filters with empty memories: a few readings far from all
# others, which a fit of everything else would be bent by. They are sought beside the prediction
# of a fit without the ends, so that they need not be alone to stand out.

LONGEST_S, LONGEST_SETTLING_SHARE = (
    2.0,
    0.02,
)  # s, and of the recording: an end that is longer is no end
USUAL = 0.999  # of the other residuals are smaller
BEYOND = 3.0  # times that: an end that stands out


def find_settling(readings: np.ndarray, motion: Motion) -> tuple[np.ndarray, tuple[Message, ...]]:
    """Which readings (n, 6) bool at the ends say nothing, and remarks on them.

    readings: (n, 6) rad/s and m/s². An end is twice as long as readings of one channel stand out,
    and of all: a filter's go on settling when they no longer do, or follow a motion that begins.
    """
    count, length = len(readings), 0
    if motion.interval > 0.0:
        length = int(min(LONGEST_S / motion.interval, LONGEST_SETTLING_SHARE * count))
    masked = np.zeros(readings.shape, bool)
    if not length:
        return masked, ()
    ends = np.zeros(readings.shape, bool)
    ends[:length] = ends[-length:] = True
    residual = np.abs(readings - plain_prediction(readings, motion, ends))
    remarks: list[Message] = []
    for rows, name in ((slice(0, length), "start"), (slice(-1, -length - 1, -1), "end")):
        settled = _settled_after(residual[rows], residual[length:-length])
        if not settled.any():
            continue
        masked[rows] |= np.arange(length)[:, None] < 2 * settled.max()
        channels = channel_names(tuple(np.flatnonzero(settled).tolist()))
        seconds = f"{2.0 * settled.max() * motion.interval:.3g}"
        remarks.append(message(f"events-settling-{name}", channels=channels, seconds=seconds))
    return masked, tuple(remarks)


def _settled_after(end: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(6,) number of rows from the outermost in which a channel's residual stands out.

    end: (rows, 6) sizes, the outermost first; others: (n, 6). None where the end itself is not
    known, and none where it stands out as far as it is looked at.
    """
    settled = np.zeros(end.shape[1], int)
    for channel, sizes in enumerate(others.T):
        known = sizes[np.isfinite(sizes)]
        usual = float(np.quantile(known, USUAL)) if len(known) else 0.0
        far = end[:, channel] > BEYOND * usual
        if usual and far[0]:
            settled[channel] = np.flatnonzero(far)[-1] + 1
    return np.where(2 * settled <= len(end), settled, 0)
