"""before_after.svg: what is left over without and with the findings, over time and frequency."""

import numpy as np
from scipy.fft import next_fast_len, rfft

from schemas.recording import MEASURED
from tasks.explain.explanation import CHANNELS, Explanation
from tasks.explain.report.excess import Cells
from tasks.explain.report.svg import (
    AFTER,
    BEFORE,
    GREY,
    INK,
    Scale,
    hours_or_minutes,
    label,
    line,
    path,
    picture,
    rect,
    ticks,
    width_of,
)
from tasks.explain.report.words import SUPERSCRIPTS, channel_name

WIDTH, LEFT, MIDDLE, SECOND, RIGHT = 1200, 90, 760, 850, 1180
TOP, ROW, PLOT = 84, 212, 150
MOST = 3  # channels that are shown
BINS = 70  # of the logarithm of the frequency
SHOWN = 0.98  # share of the cells that fit into the picture
BAND = "#d9d9d9"
GYRO_UNITS = (("°/s", 0.03, 180 / np.pi), ("°/h", 0.0, 180 / np.pi * 3600))  # from that many °/s
ACCEL_UNITS = (("m/s²", 0.5, 1.0), ("mm/s²", 5e-4, 1e3), ("µm/s²", 0.0, 1e6))


def before_after_svg(explanation: Explanation, cells: Cells) -> str:
    """The picture; its words are English with the field's symbols."""
    shown = affected(explanation, cells)
    parts = [
        label(LEFT, 20, "What is left over: reading − model", 16, bold=True),
        label(SECOND, 20, "Its spectrum, white noise = 1", 16, bold=True),
        *_legend(bool(explanation.findings)),
    ]
    for row, channel in enumerate(shown):
        y = TOP + ROW * row
        parts += _course(cells, channel, y)
        parts += _spectrum(explanation, channel, y)
    return picture(WIDTH, TOP + ROW * len(shown) + 8, "Residuals before and after", parts)


def affected(explanation: Explanation, cells: Cells) -> list[int]:
    """The channels that gain the most, or without findings those with the largest excess."""
    readings = explanation.recording.imu.stack(CHANNELS)
    gain = np.zeros(len(CHANNELS))
    for i, noise in enumerate(explanation.noise):
        known = np.isfinite(readings[:, i] - explanation.nominal[:, i] - explanation.found[:, i])
        before, after = (
            (readings[known, i] - model[known, i]) / (noise or 1.0)
            for model in (explanation.nominal, explanation.found)
        )
        gain[i] = np.sum(before**2) - np.sum(after**2)
    if not gain.max() > 0:
        known = np.where(np.isnan(cells.excess), -np.inf, cells.excess)
        gain = np.where(np.isfinite(known.max(axis=1)), np.exp(np.tanh(known.max(axis=1))), 0.0)
    order = [int(i) for i in np.argsort(-gain, kind="stable") if gain[i] > 0.01 * gain.max()]
    return sorted(order[:MOST]) or [0]


def _legend(found: bool) -> list[str]:
    """Without findings both lines are one."""
    standard = "the standard's model"
    told = [(BEFORE, f"before: {standard}"), (AFTER, "after: with the findings")]
    parts, at = [], float(LEFT)
    for colour, words in told if found else [(AFTER, standard)]:
        parts += [line(at, 42, at + 24, 42, colour, 3), label(at + 30, 46, words)]
        at += 56 + width_of(words)
    return [*parts, rect(at, 34, 24, 14, BAND), label(at + 30, 46, "noise of a mean, ±2σ")]


def _course(cells: Cells, channel: int, y: float) -> list[str]:
    """Means of the cells over time; a pale bar is what swings within a cell."""
    most = _reach(cells, channel)
    unit, factor = _unit(channel, most)
    start, end = float(cells.edges[0]), float(cells.edges[-1])

    def x(t: float) -> float:
        return LEFT + (t - start) / (end - start) * (MIDDLE - LEFT)

    def up(value: float) -> float:
        return y + PLOT / 2 - min(max(value / most, -1.0), 1.0) * PLOT / 2

    parts = [*_band(cells, channel, x, up)]
    for mean, swing, colour in (
        (cells.before, cells.swing_before, BEFORE),
        (cells.after, cells.swing_after, AFTER),
    ):
        parts += _swings(cells, mean[channel], swing[channel], colour, x, up)
        parts.append(path(_steps(cells, mean[channel], x, up), colour, 1.8))
    parts += [line(LEFT, y, LEFT, y + PLOT, INK), line(LEFT, y + PLOT, MIDDLE, y + PLOT, INK)]
    for tick in ticks(-most * factor, most * factor, 5):
        at = up(tick / factor)
        parts += [line(LEFT - 5, at, LEFT, at, INK)]
        parts.append(label(LEFT - 8, at + 4, f"{tick:g}".replace("-", "−"), 12, "end"))
    name = channel_name(CHANNELS[channel])[0]
    parts.append(label(LEFT, y - 8, f"{name} / {unit}", 14, bold=True))
    clock, size = hours_or_minutes(end - start)
    for tick in ticks(start / size, end / size, 8):
        at = x(tick * size)
        parts += [line(at, y + PLOT, at, y + PLOT + 4, INK)]
        parts.append(label(at, y + PLOT + 17, f"{tick:g}", 12, "middle"))
    parts.append(label(MIDDLE + 10, y + PLOT + 17, clock, 12))
    return parts


def _reach(cells: Cells, channel: int) -> float:
    """How far the picture reaches up and down, SI."""
    sizes = np.abs(cells.before[channel]) + cells.swing_before[channel]
    measured = np.array([kind in MEASURED for kind in cells.kinds])
    asked = sizes[measured & np.isfinite(sizes)]
    asked = asked if len(asked) else sizes[np.isfinite(sizes)]
    known = cells.noise[channel][np.isfinite(cells.noise[channel])]
    noise = float(np.median(known)) if len(known) else 0.0
    most = float(np.quantile(asked, SHOWN)) if len(asked) else 0.0
    return 1.25 * max(most, 3.0 * noise, 1e-12)


def _unit(channel: int, most: float) -> tuple[str, float]:
    """The unit in which residuals up to `most` (SI) are read, and its factor."""
    units = GYRO_UNITS if channel < 3 else ACCEL_UNITS
    in_first = most * units[0][2]
    return next((unit, factor) for unit, least, factor in units if in_first >= least)


def _band(cells: Cells, channel: int, x: Scale, up: Scale) -> list[str]:
    """Twice the noise of a mean about zero, where it is known."""
    return [
        rect(x(a), up(n), x(b) - x(a) + 0.1, up(-n) - up(n), BAND)
        for a, b, n in zip(cells.edges[:-1], cells.edges[1:], 2 * cells.noise[channel], strict=True)
        if np.isfinite(n)
    ]


def _steps(cells: Cells, means: np.ndarray, x: Scale, up: Scale) -> list[tuple[float, float]]:
    points: list[tuple[float, float]] = []
    for a, b, mean in zip(cells.edges[:-1], cells.edges[1:], means, strict=True):
        points += [(x(a), up(mean)), (x(b), up(mean))] if np.isfinite(mean) else [(np.nan, 0.0)]
    return points


def _swings(
    cells: Cells, means: np.ndarray, swings: np.ndarray, colour: str, x: Scale, up: Scale
) -> list[str]:
    return [
        rect(x(a), up(m + s), x(b) - x(a), up(m - s) - up(m + s), colour, 0.25)
        for a, b, m, s in zip(cells.edges[:-1], cells.edges[1:], means, swings, strict=True)
        if np.isfinite(m) and s > 0
    ]


def _spectrum(explanation: Explanation, channel: int, y: float) -> list[str]:
    recording, noise = explanation.recording, float(explanation.noise[channel]) or 1.0
    readings = recording.imu.stack(CHANNELS)[:, channel]
    lines = [
        (*spectrum(recording.imu.t, (readings - model[:, channel]) / noise), colour)
        for model, colour in ((explanation.nominal, BEFORE), (explanation.found, AFTER))
    ]
    every = np.concatenate([power for _, power, _ in lines])
    frequencies = lines[0][0]
    if not len(every) or not np.isfinite(every).any():
        return []
    low = min(0.3, float(np.nanquantile(every, 0.05)) / 2)
    bounds = np.log10([max(low, 1e-3), 2.0 * max(float(np.nanmax(every)), 5.0)])
    reach = np.log10([frequencies[0], frequencies[-1]])

    def x(f: float) -> float:
        return float(SECOND + (np.log10(f) - reach[0]) / (reach[1] - reach[0]) * (RIGHT - SECOND))

    def up(power: float) -> float:
        part = (np.log10(max(power, 10 ** bounds[0])) - bounds[0]) / (bounds[1] - bounds[0])
        return float(y + PLOT * (1 - part))

    parts = [line(SECOND, up(1.0), RIGHT, up(1.0), "#bbbbbb", 1.5)]
    for at, power, colour in lines:
        parts.append(path([(x(f), up(p)) for f, p in zip(at, power, strict=True)], colour))
    parts += [line(SECOND, y, SECOND, y + PLOT, INK), line(SECOND, y + PLOT, RIGHT, y + PLOT, INK)]
    parts += _decades(bounds, lambda p: up(10.0**p), SECOND, None)
    parts += _decades(reach, lambda p: x(10.0**p), None, y + PLOT)
    parts.append(label(RIGHT, y + PLOT + 34, "frequency / Hz", 12, "end", GREY))
    parts.append(label(SECOND, y - 8, channel_name(CHANNELS[channel])[0], 14, bold=True))
    return parts


def spectrum(t: np.ndarray, whitened: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(frequencies Hz, power): white noise of standard deviation 1 has power 1 everywhere.

    One periodogram under a Hann window, averaged in even steps of the logarithm of the
    frequency; rows that are not known count as zeros.
    """
    known = np.isfinite(whitened)
    if known.sum() < 32:
        return np.zeros(0), np.zeros(0)
    window = np.hanning(len(whitened)) * known
    signal = np.where(known, whitened, 0.0)
    signal = (signal - signal[known].mean()) * window
    n = next_fast_len(len(signal), real=True)
    power = np.abs(rfft(signal, n)) ** 2 / np.sum(window**2)
    step = float(np.median(np.diff(t)))
    frequency = np.arange(len(power)) / (n * step)
    first = 2.0 / (len(signal) * step)
    edges = np.geomspace(first, frequency[-1], BINS + 1)
    places = np.digitize(frequency, edges) - 1
    inside = (places >= 0) & (places < BINS)
    counts = np.bincount(places[inside], minlength=BINS)
    sums = np.bincount(places[inside], power[inside], minlength=BINS)
    full = counts > 0
    return np.sqrt(edges[:-1] * edges[1:])[full], sums[full] / counts[full]


def _decades(bounds: np.ndarray, at: Scale, left: float | None, below: float | None) -> list[str]:
    """Ticks at powers of ten, every so many that they stay apart."""
    first, last = int(np.ceil(bounds[0] - 1e-9)), int(np.floor(bounds[1] + 1e-9))
    every = max(1, (last - first) // 5 + ((last - first) % 5 > 0))
    parts = []
    for power in range(first, last + 1, every):
        word = f"10{str(power).translate(SUPERSCRIPTS)}" if abs(power) > 1 else f"{10.0**power:g}"
        place = at(float(power))
        if left is not None:
            parts += [line(left - 5, place, left, place, INK)]
            parts.append(label(left - 8, place + 4, word, 12, "end"))
        elif below is not None:
            parts += [line(place, below, place, below + 4, INK)]
            parts.append(label(place, below + 17, word, 12, "middle"))
    return parts
