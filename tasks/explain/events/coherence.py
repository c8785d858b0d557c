"""One line: its frequency, its waves, and whether it is there all the time."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import gamma

from tasks.explain.events.spectrum import Spectrum

PIECES = 24  # of the recording, in each of which a line must be
FEW = 8  # pieces, the loudest, without which a line must still be there
LEFT = 0.4  # of what a line would have in the other pieces, that must be there
PART = 0.5  # of what a line would have there, that rests and turns must have
SEEN = 3.0  # standard uncertainties from which a channel has the line


@dataclass(frozen=True)
class Line:
    """A sine wave. waves: (6,) complex, reading Re(wave·exp(2πi·f·t)); u: (6,) of an amplitude.

    power: over that of the noise, summed over channels. p_value: corrected.
    """

    frequency: float
    u_frequency: float
    waves: np.ndarray
    u: np.ndarray
    power: float
    p_value: float

    @property
    def channels(self) -> tuple[int, ...]:
        """The channels that the line is seen in."""
        seen = np.abs(self.waves) > SEEN * self.u
        strongest = int(np.argmax(np.abs(self.waves) / self.u))
        return tuple(np.flatnonzero(seen).tolist()) or (strongest,)

    def course(self, t: np.ndarray) -> np.ndarray:
        """What the line adds to the readings (n, 6), in the channels that have it."""
        added = np.zeros((len(t), 6))
        turn = np.exp(2j * np.pi * self.frequency * t)
        for channel in self.channels:
            added[:, channel] = (self.waves[channel] * turn).real
        return added


@dataclass(frozen=True)
class Heard:
    """What a line is looked for in: t (n,) s, white (n, 6) readings over their noise, 0: unknown.

    weight: (n, 6) one over the noise, 0: unknown. turning: (n,) bool.
    """

    t: np.ndarray
    white: np.ndarray
    weight: np.ndarray
    turning: np.ndarray

    @property
    def span(self) -> float:
        """s"""
        return float(self.t[-1] - self.t[0] + np.median(np.diff(self.t)))


def line_at(heard: Heard, spectrum: Spectrum, near: float, tried: int) -> Line:
    """The line at about a frequency (Hz), by least squares; tried: frequencies in all."""
    t, has, span = heard.t, spectrum.channels, heard.span
    sums, information = _pieces(heard, near)
    ends = _ends(len(t))
    middle = np.add.reduceat(t, ends) / np.diff(np.append(ends, len(t)))
    total = information.sum(axis=0)
    level = spectrum.level_at(near)
    offsets = np.linspace(-1.0, 1.0, 401) / span
    turned = np.exp(-2j * np.pi * offsets[:, None] * middle) @ sums[:, has]
    powers = (np.abs(turned) ** 2 / (2 * total[has] * level)).sum(axis=1)
    best = int(powers.argmax())
    power = float(powers[best])
    waves, u = np.zeros(6, complex), np.full(6, np.inf)
    waves[has] = turned[best] / total[has]
    u[has] = np.sqrt(level / total[has])
    # Cramér and Rao's bound of the frequency of a sine wave in white noise.
    u_frequency = np.sqrt(1.5 / power) / (np.pi * span)
    p_value = min(1.0, float(tried * gamma.sf(power, len(has))))
    return Line(near + float(offsets[best]), float(u_frequency), waves, u, power, p_value)


def stays(heard: Heard, line: Line) -> bool:
    """Whether a line is there all the time, at rest and while the table turns."""
    sums, information = _pieces(heard, line.frequency)
    parts = (sums * line.waves.conj()).real.sum(axis=1)
    expected = (information * np.abs(line.waves) ** 2).sum(axis=1)
    others = np.argsort(parts)[:-FEW]
    spread = parts[others].sum() > LEFT * expected[others].sum()
    return bool(spread) and all(_has(heard, line, rows) for rows in (heard.turning, ~heard.turning))


def _has(heard: Heard, line: Line, rows: np.ndarray) -> bool:
    """Whether rows (n,) bool have their part in a line, as far as noise allows."""
    wave = np.exp(-2j * np.pi * line.frequency * heard.t[rows])
    information = (heard.weight[rows] ** 2).sum(axis=0) / 2
    expected = float((information * np.abs(line.waves) ** 2).sum())
    sums = wave @ (heard.white[rows] * heard.weight[rows])
    part = float((sums * line.waves.conj()).real.sum())
    return part >= PART * expected - np.sqrt(expected)


def _ends(rows: int) -> np.ndarray:
    return np.linspace(0, rows, PIECES + 1).astype(int)[:-1]


def _pieces(heard: Heard, frequency: float) -> tuple[np.ndarray, np.ndarray]:
    """Of each piece (PIECES, 6): the sum of readings times the wave, and the information."""
    turn = np.exp(-2j * np.pi * frequency * heard.t)
    ends = _ends(len(heard.t))
    sums = np.add.reduceat((heard.white * heard.weight) * turn[:, None], ends, axis=0)
    return sums, np.add.reduceat(heard.weight**2, ends, axis=0) / 2
