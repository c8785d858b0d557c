"""Lines: a frequency that is there all the time, as mains pick-up is."""

import numpy as np
from scipy.stats import gamma

from tasks.explain.events.coherence import Heard, Line, line_at, stays
from tasks.explain.events.naming import Lines, events_of, near_mains
from tasks.explain.events.spectrum import STRETCH, Spectrum, spectrum_of

FALSE_ALARM = 2e-4  # of one recording, for the mains and for all other frequencies
NEARLY = 0.7  # of the power that is sure: from here a line is measured closely
MOST_LINES = 8
MOST_OTHERS = 3  # that come and go: where so many do, it is not lines that are heard
BESIDE = 40  # bins beside a line that are not looked at again: no line is quite sharp
CANDIDATES = 4  # of each kind that are measured


def find_lines(
    t: np.ndarray, residual: np.ndarray, noise: np.ndarray, turning: np.ndarray
) -> tuple[Lines, ...]:
    """Lines in what a fit leaves (n, 6), NaN: not known; noise: (n, 6), its level at each row.

    turning: (n,) bool; what is there only while the table turns, or only at rest, is no line.
    """
    if len(t) < 4 * STRETCH:
        return ()
    known = np.isfinite(residual) & (noise > 0)
    weight = np.divide(1.0, noise, out=np.zeros(noise.shape), where=known)
    white = np.where(known, residual, 0.0) * weight
    pure = white  # without what are lines, but with all that comes and goes
    found, kept = list[Line](), list[Line]()
    while len(found) < MOST_LINES and len(found) - len(kept) < MOST_OTHERS and white.any():
        line = _strongest(Heard(t, white, weight, turning), [each.frequency for each in found])
        if line is None:
            break
        found.append(line)
        course = line.course(t) * weight
        if stays(Heard(t, pure, weight, turning), line):
            kept.append(line)
            pure = pure - course
        white = white - course
    return events_of(kept, 1 / float(np.median(np.diff(t))))


def _strongest(heard: Heard, known: list[float]) -> Line | None:
    """The strongest line, of the mains or of any other frequency, but for those known."""
    spectrum = spectrum_of(heard.t, heard.white)
    rate = 1 / float(np.median(np.diff(heard.t)))
    mains = near_mains(spectrum.frequency, rate)
    for frequency in known:
        spectrum.power[np.abs(spectrum.frequency - frequency) < BESIDE / heard.span] = 0.0
    lines = [*_sure(heard, spectrum, mains), *_sure(heard, spectrum, ~mains)]
    return max(lines, key=lambda line: line.power, default=None)


def _sure(heard: Heard, spectrum: Spectrum, among: np.ndarray) -> list[Line]:
    """The lines that are sure, of the highest powers among some frequencies (bins,) bool."""
    tried = int(among.sum())
    power = np.where(among, spectrum.power, 0.0)
    threshold = NEARLY * gamma.isf(FALSE_ALARM / max(tried, 1), len(spectrum.channels))
    lines = []
    for _ in range(CANDIDATES):
        top = int(power.argmax())
        if power[top] < threshold:
            break
        line = line_at(heard, spectrum, float(spectrum.frequency[top]), tried)
        if line.p_value < FALSE_ALARM:
            lines.append(line)
            break
        power[max(0, top - 4) : top + 5] = 0.0
    return lines
