"""Spectral lines that persist throughout: mains pick-up, aliased or not, and others.

Fits one spectral line: frequency and amplitudes by least squares, and whether it is steady.
"""

from dataclasses import dataclass
from itertools import chain, product
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.stats import gamma

from schemas.discrepancy import FoundParameter
from tasks.explain.events.event import (
    LEVEL_BINS,
    AddedSignal,
    Residual,
    Spectrum,
    amplitude_parameters,
    channel_names,
    significant_channels,
    spectrum_of,
)
from tasks.model.term import ACCEL_FIRST
from tasks.words import Sayable, message

FALSE_ALARM = 2e-4  # of one recording, for the mains and for all other frequencies
NEARLY_SIGNIFICANT = 0.7  # of the power that is significant: from here a line is fitted
MAX_LINES = 8
MAX_UNSTEADY = 3  # where so many come and go, they are no lines
BESIDE = 40  # bins beside a line that are not looked at again: no line is quite sharp
MAX_CANDIDATES = 4  # of the mains and of all others, that are fitted
MAINS = tuple(product((1, 2, 3), (50.0, 60.0)))  # harmonics and frequencies, Hz
TOLERANCE = 0.15  # Hz that the mains may be off
SAME = 2e-3  # Hz by which two lines of one mains may differ on its frequency
PIECES = 24  # of the recording, in each of which a line must be
LOUDEST = 8  # pieces without which a line must still be there
MIN_IN_OTHERS = 0.4  # of what a line would have in the other pieces, that must be there
MIN_IN_PIECE = 0.4  # of its mean amplitude: with less in a piece a line is not there
MAX_WITHOUT = 1  # pieces without it: a line that fades or begins later is not there all the time
MIN_IN_STATE = 0.5  # of what a line would have at rest, or in rotation, that must be there
SIGNIFICANT = 3.0  # standard uncertainties from which a channel has the line
OFFSETS = np.linspace(-1.0, 1.0, 401)  # frequencies that are tried, over one per span
CLOSEST = 0.3  # waves per recording, below half the sample rate: there sine and cosine are alike
ROTATING = 0.05  # rad/s
STOP = 1.0  # s: what is shorter is a reversal, not a rest


@dataclass(frozen=True)
class FittedLine:
    """A sine wave. amplitudes: (6,) complex, reading Re(amplitude·exp(2πi·f·t)); u: (6,) of one.

    power: over that of the noise, summed over channels. p_value: corrected.
    """

    frequency: float
    u_frequency: float
    amplitudes: np.ndarray
    u: np.ndarray
    power: float
    p_value: float

    @property
    def channels(self) -> tuple[int, ...]:
        """The channels in which the line is significant; at least the strongest."""
        return significant_channels(np.abs(self.amplitudes) / self.u, SIGNIFICANT)

    def signal(self, t: np.ndarray) -> np.ndarray:
        """What the line adds to the readings (n, 6), in the channels that have it."""
        added = np.zeros((len(t), 6))
        wave = np.exp(2j * np.pi * self.frequency * t)
        for channel in self.channels:
            added[:, channel] = (self.amplitudes[channel] * wave).real
        return added


class Harmonic(NamedTuple):
    """A line as a harmonic of its source; frequencies: that the source may then have, Hz."""

    harmonic: int
    frequencies: tuple[float, ...]
    line: FittedLine


def find_lines(residual: Residual) -> tuple[AddedSignal, ...]:
    """Steady lines in a residual; one that occurs only at rest or only in rotation is not
    steady.
    """
    if len(residual.t) < 4 * LEVEL_BINS:
        return ()
    cleaned = residual  # of all lines; the residual only of the steady ones
    lines, steady = list[FittedLine](), list[FittedLine]()
    while (
        len(lines) < MAX_LINES and len(lines) - len(steady) < MAX_UNSTEADY and cleaned.white.any()
    ):
        line = strongest_line(cleaned, [known.frequency for known in lines])
        if line is None:
            break
        lines.append(line)
        signal = line.signal(residual.t)
        if is_steady(residual, line):
            steady.append(line)
            residual = residual.minus(signal)
        cleaned = cleaned.minus(signal)
    return events_of_lines(steady, 1 / residual.interval)


def strongest_line(residual: Residual, known: list[float]) -> FittedLine | None:
    """The strongest line, of the mains or of any other frequency, but for those known (Hz)."""
    spectrum = spectrum_of(residual)
    mains = at_mains(spectrum.frequency, 1 / residual.interval)
    for frequency in known:
        spectrum.power[np.abs(spectrum.frequency - frequency) < BESIDE / residual.span] = 0.0
    lines = [_significant(residual, spectrum, among) for among in (mains, ~mains)]
    return max((line for line in lines if line), key=lambda line: line.power, default=None)


def _significant(residual: Residual, spectrum: Spectrum, among: np.ndarray) -> FittedLine | None:
    """The first significant line, by falling power, among some frequencies (bins,) bool."""
    tried = int(among.sum())
    power = np.where(among, spectrum.power, 0.0)
    threshold = gamma.isf(FALSE_ALARM / max(tried, 1), len(spectrum.channels))
    for _ in range(MAX_CANDIDATES):
        top = int(power.argmax())
        if power[top] < NEARLY_SIGNIFICANT * threshold:
            break
        line = fit_line(residual, spectrum, float(spectrum.frequency[top]), tried)
        if line.p_value < FALSE_ALARM:
            return line
        power[max(0, top - 4) : top + 5] = 0.0
    return None


def events_of_lines(lines: list[FittedLine], rate: float) -> tuple[AddedSignal, ...]:
    """Those of the mains together, every other by itself; rate: of the samples, Hz.

    A harmonic is one of the mains only beside its fundamental, and at that frequency's multiple:
    by itself, and aliased, any line may lie near one.
    """
    sources = [(line, mains_of(line.frequency, rate)) for line in lines]
    near = [Harmonic(*source, line) for line, source in sources if source is not None]
    fundamental = next((each for each in near if each.harmonic == 1), None)
    mains = [each for each in near if fundamental and _agree(each, fundamental)]
    frequencies = {each.line.frequency for each in mains}
    unnamed = tuple(
        _event("unnamed", [Harmonic(1, (line.frequency,), line)])
        for line in lines if line.frequency not in frequencies
    )  # fmt: skip
    mains.sort(key=lambda each: each.harmonic)
    return (*unnamed, _event("mains_pickup", mains)) if mains else unnamed


def _agree(harmonic: Harmonic, fundamental: Harmonic) -> bool:
    """Whether two lines may come from mains of one frequency."""
    apart = min(abs(a - b) for a in harmonic.frequencies for b in fundamental.frequencies)
    u = float(np.hypot(harmonic.line.u_frequency, fundamental.line.u_frequency))
    return apart < SAME + 5 * u


def at_mains(frequencies: np.ndarray, rate: float) -> np.ndarray:
    """Which frequencies (k,) Hz the mains may be seen at, sampled at a rate (Hz): (k,) bool."""
    near = np.zeros(len(frequencies), bool)
    for harmonic, nominal in MAINS:
        alias = abs(harmonic * nominal - round(harmonic * nominal / rate) * rate)
        near |= np.abs(frequencies - alias) <= harmonic * TOLERANCE
    return near


def mains_of(frequency: float, rate: float) -> tuple[int, tuple[float, ...]] | None:
    """Which harmonic of the mains is seen at a frequency (Hz), sampled at a rate (Hz).

    With it what the mains' frequency may be: two, where both sides of a fold are within reach.
    None where no harmonic, or its alias, lies there.
    """
    for harmonic, nominal in MAINS:
        fold = round(harmonic * nominal / rate)
        sources = {(k * rate + side * frequency) / harmonic
                   for k in (fold - 1, fold, fold + 1) for side in (1, -1)}  # fmt: skip
        within = tuple(sorted(each for each in sources if abs(each - nominal) <= TOLERANCE))
        if within:
            return harmonic, within
    return None


def _event(effect: str, harmonics: list[Harmonic]) -> AddedSignal:
    """The event of the lines of one source, by rising harmonic."""
    number, frequencies, first = harmonics[0]
    lines = [each.line for each in harmonics]
    # Both sides of a fold are equally likely: the interval holds both.
    u = float(np.hypot(first.u_frequency / number, np.ptp(frequencies) / 2))
    frequency = FoundParameter(name="frequency", value=float(np.mean(frequencies)), unit="Hz", u=u)
    amplitudes = [
        amplitude_parameters(
            line.channels, line.amplitudes, line.u, f"_{harmonic}" if harmonic > 1 else ""
        )
        for harmonic, _, line in harmonics
    ]
    channels = tuple(sorted({channel for line in lines for channel in line.channels}))
    names = channel_names(channels)
    title: Sayable = ""
    if effect == "unnamed":
        description = message("events-line", frequency=f"{first.frequency:.4f}", channels=names)
    else:
        source = " / ".join(f"{each:.3f}" for each in frequencies)
        description = message(
            "events-mains", frequency=source,
            lines=", ".join(f"{line.frequency:.4f} Hz" for line in lines), channels=names,
        )  # fmt: skip
        if first.frequency not in frequencies:
            title = message("events-folded-mains", line=f"{first.frequency:.3f}", frequency=source)
    return AddedSignal(
        effect, channels, (frequency, *chain(*amplitudes)), min(line.p_value for line in lines),
        description, tuple(line.signal for line in lines),
        frequencies=tuple(line.frequency for line in lines), title=title,
    )  # fmt: skip


def fit_line(residual: Residual, spectrum: Spectrum, near: float, tried: int) -> FittedLine:
    """The line at about a frequency (Hz), by least squares; tried: frequencies in all."""
    channels, span = spectrum.channels, residual.span
    starts = _piece_starts(len(residual.t))
    wave = np.exp(-2j * np.pi * near * residual.t)
    sums = np.add.reduceat((residual.white * residual.weight) * wave[:, None], starts, axis=0)
    middle = np.add.reduceat(residual.t, starts) / np.diff(np.append(starts, len(residual.t)))
    weights = residual.weight[:, channels] ** 2
    total = weights.sum(axis=0) / 2
    images = np.add.reduceat(weights * wave[:, None] ** 2, starts, axis=0) / 2
    level = spectrum.level_at(near)
    highest = spectrum.nyquist - CLOSEST / span
    offsets = OFFSETS[near + OFFSETS / span <= highest] / span
    shift = np.exp(-2j * np.pi * offsets[:, None] * middle)
    shifted, image = shift @ sums[:, channels], shift**2 @ images
    # Near half the sample rate a wave and its image are not orthogonal: both by least squares.
    amplitude = (total * shifted - image * shifted.conj()) / (total**2 - np.abs(image) ** 2)
    powers = ((shifted.conj() * amplitude).real / (2 * level)).sum(axis=1)
    best = int(powers.argmax())
    power = float(powers[best])
    amplitudes, u = np.zeros(6, complex), np.full(6, np.inf)
    amplitudes[channels] = amplitude[best]
    u[channels] = np.sqrt(level * total / (total**2 - np.abs(image[best]) ** 2))
    # Cramér and Rao's bound of the frequency of a sine wave in white noise.
    u_frequency = np.sqrt(1.5 / power) / (np.pi * span)
    p_value = min(1.0, float(tried * gamma.sf(power, len(channels))))
    frequency = near + float(offsets[best])
    return FittedLine(frequency, float(u_frequency), amplitudes, u, power, p_value)


def is_steady(residual: Residual, line: FittedLine) -> bool:
    """Whether a line is there all the time, at rest and in rotation, as far as noise allows."""
    wave = np.exp(-2j * np.pi * line.frequency * residual.t)
    weighted = (residual.white * residual.weight) @ line.amplitudes.conj()
    turning = wave * weighted
    part = turning.real
    expected = ((residual.weight * (line.amplitudes / wave[:, None]).real) ** 2).sum(axis=1)
    starts = _piece_starts(len(residual.t))
    parts, wholes = (np.add.reduceat(values, starts) for values in (part, expected))
    # By its size in each piece, whatever its phase there: what wanders is there all the same.
    sizes = np.abs(np.add.reduceat(turning, starts))
    if (sizes + np.sqrt(wholes) < MIN_IN_PIECE * wholes).sum() > MAX_WITHOUT:
        return False
    others = np.argsort(parts)[:-LOUDEST]
    if parts[others].sum() <= MIN_IN_OTHERS * wholes[others].sum():
        return False
    speed = np.linalg.norm(residual.motion.rate, axis=1)
    rotating = maximum_filter1d(speed, 1 + round(STOP / residual.interval)) > ROTATING
    return all(
        part[rows].sum() >= MIN_IN_STATE * expected[rows].sum() - np.sqrt(expected[rows].sum())
        for rows in (rotating, ~rotating)
    )


def _piece_starts(rows: int) -> np.ndarray:
    return np.linspace(0, rows, PIECES + 1).astype(int)[:-1]


# Spectral lines so strong that they would shape every fit: removed before a search.

DOMINANT = 0.05  # of a channel's residual variance that a line must be
LEVER = 0.3  # m: how far from the axis accelerometers may be
BEYOND_MOTION = 2.0  # times the motion's own amplitude: more than any delay or filter of it makes


def find_dominant_lines(residual: Residual, predicted: np.ndarray) -> tuple[AddedSignal, ...]:
    """Steady lines that would shape every fit: most of a channel's residual, and not the motion's.

    predicted: (n, 6) readings, whose amplitude at a frequency bounds what a wrong delay, filter or
    scale factor leaves there. A periodic motion has its own lines, which are left to the fit.
    """
    if len(residual.t) < 4 * LEVEL_BINS:
        return ()
    cleaned, passed, lines = residual, list[float](), list[FittedLine]()
    while len(passed) < MAX_LINES and cleaned.white.any():
        line = strongest_line(cleaned, passed)
        if line is None or not _dominates(cleaned, line):
            break
        passed.append(line.frequency)
        if _beyond_motion(residual, line, predicted) and is_steady(cleaned, line):
            lines.append(line)
            cleaned = cleaned.minus(line.signal(residual.t))
    return events_of_lines(lines, 1 / residual.interval)


def _dominates(residual: Residual, line: FittedLine) -> bool:
    """Whether a line is a large part of a channel's residual variance."""
    known = (residual.weight > 0).sum(axis=0)
    variance = (residual.values**2).sum(axis=0) / np.maximum(known, 1)
    return bool((0.5 * np.abs(line.amplitudes) ** 2 > DOMINANT * variance)[known > 0].any())


def _beyond_motion(residual: Residual, line: FittedLine, predicted: np.ndarray) -> bool:
    """Whether, in its strongest channel, a line is larger than the motion can have made it."""
    channel = int((np.abs(line.amplitudes) / line.u).argmax())
    made = _amplitude(residual.t, predicted[:, channel], line.frequency)
    if channel >= ACCEL_FIRST:
        motion = residual.motion
        squares = [motion.rate[:, i] * motion.rate[:, j] for i in range(3) for j in range(i, 3)]
        felt = [*motion.acceleration.T, *squares]
        made += LEVER * sum(_amplitude(residual.t, each, line.frequency) for each in felt)
    return abs(line.amplitudes[channel]) > BEYOND_MOTION * made


def _amplitude(t: np.ndarray, signal: np.ndarray, frequency: float) -> float:
    """The amplitude that a signal (n,), NaN where unknown, has at a frequency (Hz)."""
    known = np.isfinite(signal)
    if not known.any():
        return 0.0
    wave = np.exp(-2j * np.pi * frequency * t[known])
    return float(2.0 * abs(wave @ (signal[known] - signal[known].mean())) / known.sum())
