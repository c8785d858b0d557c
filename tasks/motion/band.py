"""Derivatives of a tracked pose, within the band where motion exceeds noise.

The acceleration of a body falls off with frequency; that of a noise that is the same at all
frequencies rises with its fourth power. Where the spectrum of both together is least they are
about equal, and there the band ends. Above it nothing is known. The filter is that of Wiener for a
motion that falls off with the eighth power, which is a smoothing spline's (Woltring, Adv. Eng.
Softw. 8, 1986): h = 1/(1 + (f/f₀)⁸), without a shift in time. What it takes from the motion is
filtered once more and put back (Tukey's twicing, Exploratory Data Analysis, 1977, 16): alone it
takes half a percent at half the band, which a regression sees as a scale factor.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.fft import irfft, rfft, rfftfreq

WINDOW = 4.0  # s: of the spectrum
LOWEST, HIGHEST = 0.5, 60.0  # Hz: bodies that are tracked move within
PER_OCTAVE = 3
NEAR_LEAST = 1.1  # times the least power above: the motion is no longer seen
ROUNDING = 1e-9  # rad or m: second differences of less are arithmetic
SHARED = 0.8  # of the poses' power that gyros account for: noise is a quarter of the motion
FALL = 8  # power of the frequency with which one pass of the filter falls off


def band_edge(spans: Sequence[np.ndarray], interval: float) -> float:
    """Where the band ends, Hz, of courses (n, k) sampled evenly, each stretch without a gap.

    The lowest frequency, from that of the strongest motion up, whose power in the second
    derivative is no more than NEAR_LEAST times the least above it; the highest that is looked at
    where the motion is seen up to there.
    """
    from scipy.signal import welch  # late: few recordings have a pose

    bends = np.concatenate([np.diff(stretch, 2, axis=0) for stretch in spans])
    top = min(HIGHEST, 0.45 / interval)
    if np.sqrt((bends**2).mean()) < ROUNDING:
        return top
    length = min(round(WINDOW / interval), len(bends))
    frequency, power = welch(bends, 1.0 / interval, nperseg=length, axis=0)
    # What a second difference makes of a frequency, beside a second derivative.
    reach = np.maximum(2.0 * np.sin(np.pi * frequency * interval), 1e-12)
    power = power.sum(axis=1) * (2.0 * np.pi * frequency / reach) ** 4
    count = max(2, round(PER_OCTAVE * np.log2(top / LOWEST)))
    edges = np.geomspace(LOWEST, top, count + 1)
    which = np.searchsorted(edges, frequency) - 1
    bands = [k for k in range(count) if (which == k).any()]
    middle = np.sqrt(edges[:-1] * edges[1:])[bands]
    level = np.array([power[which == k].mean() for k in bands])
    strongest = int(np.argmax(level / middle**5))
    least = np.minimum.accumulate(level[::-1])[::-1]
    ends = np.flatnonzero(level <= NEAR_LEAST * least)
    return float(middle[ends[ends >= strongest][0]])


def seen_by_gyros(
    turned: Sequence[np.ndarray], gyros: Sequence[np.ndarray], interval: float
) -> float:
    """Hz up to where the gyros (n, 3) see the turns (n, 3) of the same stretches; 0: nowhere.

    By the multiple coherence of the turns' rates with the three gyros (Bendat, Piersol, Random
    Data, 2010, 7.3), which neither axes, scale factors nor a delay change: up to where the power
    that both have in common exceeds SHARED of all by most. The poses' noise may have any spectrum.
    """
    length = round(WINDOW / interval)
    window = np.hanning(length)[:, None]
    count = length // 2 + 1
    power, crossed = (np.zeros((count, 3, 3), complex) for _ in range(2))
    own = np.zeros(count)
    for course, read in zip(turned, gyros, strict=True):
        rates = np.gradient(course, interval, axis=0)
        for first in range(0, len(course) - length + 1, max(1, length // 2)):
            rows = slice(first, first + length)
            x, y = (rfft(window * (each[rows] - each[rows].mean(axis=0)), axis=0)
                    for each in (read, rates))  # fmt: skip
            power += x.conj()[:, :, None] * x[:, None, :]
            crossed += x.conj()[:, :, None] * y[:, None, :]
            own += (np.abs(y) ** 2).sum(axis=1)
    frequency = rfftfreq(length, interval)
    top, gain = min(HIGHEST, 0.45 / interval), [0.0]
    edges = np.geomspace(LOWEST, top, max(2, round(PER_OCTAVE * np.log2(top / LOWEST))) + 1)
    for low, high in pairwise(edges):
        rows = (frequency >= low) & (frequency < high)
        a, b = power[rows].sum(axis=0), crossed[rows].sum(axis=0)
        shared = np.einsum("ik,ik->", b.conj(), np.linalg.lstsq(a, b, rcond=None)[0]).real
        gain.append(gain[-1] + shared - SHARED * own[rows].sum())
    best = int(np.argmax(gain))  # a band without motion between two that have some costs little
    return float(np.sqrt(edges[best - 1] * edges[best])) if best else 0.0


def response(frequency: np.ndarray, edge: float) -> np.ndarray:
    """What the filter passes of each frequency, Hz, for a band up to `edge` Hz: h + h (1 − h)."""
    once = 1.0 / (1.0 + (frequency / edge) ** FALL)
    return np.asarray(once * (2.0 - once))


def derivatives(
    values: np.ndarray, interval: float, edge: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Smoothed values (n, k), first and second derivative per s and s², of an even course.

    Beyond its ends the course is taken to go on turned by half a turn, so that value and slope are
    right there and the second derivative is not: within about two periods of the band's edge.
    """
    count = len(values)
    slope = (values[-1] - values[0]) / (count - 1)
    line = values[0] + slope * np.arange(count)[:, None]
    course = values - line
    ring = np.concatenate([course, -course[-2:0:-1]])
    spectrum, frequency = rfft(ring, axis=0), rfftfreq(len(ring), interval)
    turn = (2.0j * np.pi * frequency)[:, None]
    passed = response(frequency, edge)[:, None] * spectrum
    smooth, first, second = (
        irfft(passed * turn**order, len(ring), axis=0)[:count] for order in (0, 1, 2)
    )
    return smooth + line, first + slope / interval, second
