"""Spectral lines that are there all the time, as mains pick-up is."""

import numpy as np
from scipy.stats import gamma

from tasks.explain.events.line_fit import Line, fit_line, is_steady
from tasks.explain.events.mains import SpectralLines, at_mains, events_of_lines
from tasks.explain.events.residual import Residual
from tasks.explain.events.spectrum import LEVEL_BINS, Spectrum, spectrum_of

FALSE_ALARM = 2e-4  # of one recording, for the mains and for all other frequencies
NEARLY_SIGNIFICANT = 0.7  # of the power that is significant: from here a line is fitted
MAX_LINES = 8
MAX_UNSTEADY = 3  # where so many come and go, they are no lines
BESIDE = 40  # bins beside a line that are not looked at again: no line is quite sharp
MAX_CANDIDATES = 4  # of the mains and of all others, that are fitted


def find_lines(residual: Residual) -> tuple[SpectralLines, ...]:
    """Steady lines in a residual; one that is there only at rest or in rotation is none."""
    if len(residual.t) < 4 * LEVEL_BINS:
        return ()
    cleaned = residual  # of all lines; the residual only of the steady ones
    lines, steady = list[Line](), list[Line]()
    while (
        len(lines) < MAX_LINES and len(lines) - len(steady) < MAX_UNSTEADY and cleaned.white.any()
    ):
        line = _strongest(cleaned, [known.frequency for known in lines])
        if line is None:
            break
        lines.append(line)
        signal = line.signal(residual.t)
        if is_steady(residual, line):
            steady.append(line)
            residual = residual.minus(signal)
        cleaned = cleaned.minus(signal)
    return events_of_lines(steady, 1 / residual.interval)


def _strongest(residual: Residual, known: list[float]) -> Line | None:
    """The strongest line, of the mains or of any other frequency, but for those known (Hz)."""
    spectrum = spectrum_of(residual)
    mains = at_mains(spectrum.frequency, 1 / residual.interval)
    for frequency in known:
        spectrum.power[np.abs(spectrum.frequency - frequency) < BESIDE / residual.span] = 0.0
    lines = [_significant(residual, spectrum, among) for among in (mains, ~mains)]
    return max((line for line in lines if line), key=lambda line: line.power, default=None)


def _significant(residual: Residual, spectrum: Spectrum, among: np.ndarray) -> Line | None:
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
