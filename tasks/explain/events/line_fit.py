"""Fits one spectral line: frequency and amplitudes by least squares, and whether it is steady."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.stats import gamma

from tasks.explain.events.event import significant_channels
from tasks.explain.events.residual import Residual
from tasks.explain.events.spectrum import Spectrum

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
    highest = 0.5 / residual.interval - CLOSEST / span
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
