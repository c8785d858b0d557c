"""before_after.svg: residuals without and with the findings, over time and frequency."""

from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.fft import next_fast_len, rfft

from schemas.recording import MEASURED
from tasks.explain.channels import CHANNELS
from tasks.explain.explanation import Explanation
from tasks.explain.report.cells import ExcessCells
from tasks.explain.report.names import channel_title
from tasks.rendering.chart import AFTER, BEFORE, draw, time_axis
from tasks.words import message, say
from tasks.words.quantities import power_of_ten

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEAD, ROW, PLOT, FOOT = 1040, 88, 224, 152, 46  # px
MAX_CHANNELS = 3  # that are shown
BINS = 70  # of the logarithm of the frequency
SHOWN = 0.98  # share of the cells that fit into the picture
BAND = "#d9d9d9"
GYRO_UNITS = (("°/s", 0.03, 180 / np.pi), ("°/h", 0.0, 180 / np.pi * 3600))  # from that many °/s
ACCEL_UNITS = (("m/s²", 0.5, 1.0), ("mm/s²", 5e-4, 1e3), ("µm/s²", 0.0, 1e6))


def before_after_svg(explanation: Explanation, cells: ExcessCells, language: str) -> str:
    """The picture, its words in a language."""
    shown = affected(explanation, cells)
    height = HEAD + ROW * (len(shown) - 1) + PLOT + FOOT

    def content(figure: "Figure") -> None:
        figure.set_layout_engine("none")  # it would cost as much again as the drawing
        rows = figure.subplots(len(shown), 2, squeeze=False, gridspec_kw={
            "width_ratios": (2, 1), "left": 60 / WIDTH, "right": 1 - 14 / WIDTH, "wspace": 0.15,
            "top": 1 - HEAD / height, "bottom": FOOT / height, "hspace": (ROW - PLOT) / PLOT,
        })  # fmt: skip
        for channel, (over_time, over_frequency) in zip(shown, rows, strict=True):
            _draw_means(over_time, cells, channel, language)
            _draw_spectra(over_frequency, explanation, channel, language)
        for axes, heading in zip(rows[0], ("chart-residual", "chart-spectrum"), strict=True):
            words = say(message(heading), language)
            axes.annotate(words, (0, 1), xytext=(0, 62), **HEADING)
        _draw_legend(rows[0][0], bool(explanation.findings), language)

    return draw(say(message("chart-residual.title"), language), WIDTH, height, content)


HEADING: dict[str, Any] = {
    "xycoords": "axes fraction", "textcoords": "offset points", "fontsize": 15, "weight": "bold",
}  # fmt: skip


def affected(explanation: Explanation, cells: ExcessCells) -> list[int]:
    """The channels that gain the most, or without findings those with the largest excess."""
    readings = explanation.recording.imu.stack(CHANNELS)
    noise = np.where(explanation.noise == 0, 1.0, explanation.noise)
    before, after = (
        (readings - model) / noise for model in (explanation.nominal, explanation.found)
    )
    known = np.isfinite(before - after)
    gain = np.sum(before**2 - after**2, axis=0, where=known)
    if not gain.max() > 0:
        excess = np.where(np.isnan(cells.excess), -np.inf, cells.excess).max(axis=1)
        gain = np.where(np.isfinite(excess), np.exp(np.tanh(excess)), 0.0)
    order = [int(i) for i in np.argsort(-gain, kind="stable") if gain[i] > 0.01 * gain.max()]
    return sorted(order[:MAX_CHANNELS]) or [0]


def _draw_legend(axes: Any, found: bool, language: str) -> None:
    """Without findings both lines are one."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    model, before, after, noise = (
        say(message(f"chart-lines.{line}"), language)
        for line in ("model", "before", "after", "noise")
    )
    handles: list[Any] = [Line2D([], [], color=colour, linewidth=3, label=label)
               for colour, label in ([(BEFORE, before), (AFTER, after)] if found
                                     else [(AFTER, model)])]  # fmt: skip
    handles.append(Patch(color=BAND, label=noise))
    axes.legend(handles=handles, ncols=3, loc="lower left", bbox_to_anchor=(0, 1.16), borderpad=0,
                borderaxespad=0, columnspacing=4.0)  # fmt: skip


def _draw_means(axes: Any, cells: ExcessCells, channel: int, language: str) -> None:
    """Means of the cells over time; a pale bar is what swings within a cell."""
    reach = _reach(cells, channel)
    unit, factor = _unit(channel, reach)
    top = reach * factor
    t = np.repeat(cells.edges, 2)[1:-1]

    def between(low: np.ndarray, high: np.ndarray, colour: str, opacity: float) -> None:
        low, high = (np.repeat(np.clip(y * factor, -top, top), 2) for y in (low, high))
        axes.fill_between(t, low, high, where=np.isfinite(low), color=colour, alpha=opacity,
                          linewidth=0)  # fmt: skip

    between(-2 * cells.noise[channel], 2 * cells.noise[channel], BAND, 1.0)
    for means, swings, colour in (
        (cells.before[channel], cells.swing_before[channel], BEFORE),
        (cells.after[channel], cells.swing_after[channel], AFTER),
    ):
        swings = np.where(swings > 0, swings, np.nan)
        between(means - swings, means + swings, colour, 0.25)
        shown = np.clip(means * factor, -top, top)
        axes.stairs(shown, cells.edges, baseline=None, color=colour, linewidth=1.8)
    axes.set(xlim=(cells.edges[0], cells.edges[-1]), ylim=(-top, top))
    axes.set_title(f"{_title(channel, language)} / {unit}")
    axes.locator_params(axis="y", nbins=6)
    time_axis(axes, language)


def _title(channel: int, language: str) -> str:
    return say(channel_title(CHANNELS[channel]), language)


def _reach(cells: ExcessCells, channel: int) -> float:
    """How far the picture reaches up and down, SI."""
    sizes = np.abs(cells.before[channel]) + cells.swing_before[channel]
    known = np.isfinite(sizes)
    measured = known & np.isin(cells.kinds, MEASURED)
    sizes = sizes[measured if measured.any() else known]
    noise = cells.noise[channel][np.isfinite(cells.noise[channel])]
    largest = float(np.quantile(sizes, SHOWN)) if len(sizes) else 0.0
    return 1.25 * max(largest, 3.0 * float(np.median(noise)) if len(noise) else 0.0, 1e-12)


def _unit(channel: int, reach: float) -> tuple[str, float]:
    """The unit in which residuals up to `reach` (SI) are read, and its factor."""
    units = GYRO_UNITS if channel < 3 else ACCEL_UNITS
    in_first = reach * units[0][2]
    return next((unit, factor) for unit, least, factor in units if in_first >= least)


def _draw_spectra(axes: Any, explanation: Explanation, channel: int, language: str) -> None:
    recording, noise = explanation.recording, float(explanation.noise[channel]) or 1.0
    readings = recording.imu.stack(CHANNELS)[:, channel]
    axes.set_title(_title(channel, language))
    axes.set_xlabel(say(message("chart-frequency"), language), loc="right")
    axes.axhline(1.0, color="#bbbbbb", linewidth=1.5)
    powers = []
    for model, colour in ((explanation.nominal, BEFORE), (explanation.found, AFTER)):
        frequency, power = spectrum(recording.imu.t, (readings - model[:, channel]) / noise)
        axes.loglog(frequency, power, color=colour, linewidth=1.5)
        powers.append(power)
    whole = np.concatenate(powers)
    if not np.isfinite(whole).any():
        axes.set_axis_off()
        return
    low = min(0.3, float(np.nanquantile(whole, 0.05)) / 2)
    axes.set(xlim=(frequency[0], frequency[-1]),
             ylim=(max(low, 1e-3), 2.0 * max(float(np.nanmax(whole)), 5.0)))  # fmt: skip
    axes.minorticks_off()
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(lambda power, _: power_of_ten(round(np.log10(power)))[1:] or "1")


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
    edges = np.geomspace(2.0 / (len(signal) * step), frequency[-1], BINS + 1)
    counts, sums = (np.histogram(frequency, edges, weights=w)[0] for w in (None, power))
    full = counts > 0
    return np.sqrt(edges[:-1] * edges[1:])[full], sums[full] / counts[full]
