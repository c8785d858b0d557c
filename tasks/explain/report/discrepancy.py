"""The published form of the result (`mimu-discrepancy/1`)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.fft import next_fast_len, rfft

from schemas.discrepancy import (
    Consequence,
    Detection,
    Discrepancy,
    EvidenceFor,
    ReportedFinding,
    VerdictChange,
    Where,
)
from schemas.recording import MEASURED, Segment
from schemas.text import Remark
from tasks.explain.correction.consequences import Consequences
from tasks.explain.explanation import CHANNELS, UNNAMED, Explanation, Finding, Refusal
from tasks.explain.inputs.prepared import shown_segments
from tasks.explain.report.statements import (
    channel_title,
    far_beyond,
    finding_statement,
    pattern_of,
    refused,
    setting_suspected,
    small_statement,
    title_of,
    usual_cause,
)
from tasks.explain.report.verdict import verdict_statement
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.model.term import next_step, separating_recording
from tasks.readings.robust import TO_SIGMA
from tasks.rendering import AFTER, BEFORE, draw, picture_file, time_axis
from tasks.version import code_version
from tasks.words import LANGUAGES, Sayable, message, say, statement
from tasks.words.numbers import power_of_ten

if TYPE_CHECKING:
    from matplotlib.figure import Figure


PICTURES = ("where", "before_after", "shares")
NOT_WRITTEN = statement("")


def discrepancy_of(
    explanation: Explanation, wheres: Sequence[tuple[Where, ...]], effects: Consequences
) -> Discrepancy:
    """The whole discrepancy of an explanation, in every language.

    wheres: one entry for each finding, in the order of the findings, as `effects` has them.
    Raises ValueError where their number differs from that of the findings.
    """
    left_over = {
        channel: float(value)
        for channel, value in zip(CHANNELS, explanation.left_over, strict=True)
        if np.isfinite(value)
    }
    joint = [
        tuple(n + 1 for n in some if n != own)
        for own, some in enumerate(effects.sets or [()] * len(wheres))
    ]
    parts = zip(
        explanation.findings, wheres, effects.of_findings, effects.changes, joint, strict=True
    )
    draft = Discrepancy(
        recording_id=explanation.recording.manifest.recording_id,
        digest=explanation.recording.digest,
        code_version=code_version(),
        model=statement(explanation.model),
        verdict=explanation.verdict,
        detection=Detection(p_value=explanation.p_value, false_alarm_rate=FALSE_ALARMS),
        explained_share=explanation.explained_share,
        left_over=left_over,
        findings=tuple(_published(*each, left_over, effects.together) for each in parts),
        small_remainders=tuple(
            statement(small_statement(title_of(each), each.share)) for each in explanation.small
        ),
        consequences=effects.together,
        verdict_changes=effects.changes_together,
        held_out=explanation.held_out,
        figures=tuple(picture_file(name, language) for language in LANGUAGES for name in PICTURES),
        remarks=tuple(map(statement, explanation.remarks)),
        statement=NOT_WRITTEN,
    )
    seen = [one for one in explanation.remarks if isinstance(one, Remark) and one.run == "invalid"]
    written = verdict_statement(draft, explanation.recording, seen)
    return draft.model_copy(update={"statement": written})


def _published(
    finding: Finding,
    wheres: tuple[Where, ...],
    consequences: tuple[Consequence, ...],
    changes: tuple[VerdictChange, ...],
    jointly_with: tuple[int, ...],
    left_over: Mapping[str, float],
    together: Sequence[Consequence],
) -> ReportedFinding:
    unnamed, setting = finding.effect == UNNAMED, setting_suspected(finding, left_over)
    draft = ReportedFinding(
        effect=finding.effect,
        family=finding.family,
        title=statement(title_of(finding)),
        channels=tuple(CHANNELS[i] for i in finding.channels),
        where=wheres,
        parameters=finding.parameters,
        evidence=EvidenceFor(delta_bic=finding.delta_bic, held_out_gain_nats=finding.held_out_gain),
        share=finding.share,
        homogeneity_p=finding.homogeneity_p,
        group=finding.group or None,
        common=finding.common,
        unlisted_form=finding.unlisted,
        refused=statement(refused(finding.refusal, setting))
        if finding.refusal and unnamed
        else None,
        equation=finding.equation,
        source=finding.source,
        follows=statement(pattern_of(finding)) if unnamed else None,
        indistinguishable_from=finding.indistinguishable,
        separating_recording=statement(finding.separated_by) if finding.separated_by else None,
        consequences=consequences,
        jointly_with=jointly_with,
        verdict_changes=changes,
        next=statement(next_of(finding, wheres, setting)),
        statement=NOT_WRITTEN,
    )
    text = finding_statement(draft, left_over, together)
    return draft.model_copy(update={"statement": text})


def next_of(finding: Finding, places: tuple[Where, ...], setting: bool) -> Sayable:
    """What an engineer does next: checks a setting, the fixture, the logger, or records something.

    places: by falling share. setting: a wrong setting is suspected.
    """
    if finding.effect != UNNAMED:
        return next_step(finding.effect) or finding.separated_by or _by_place(places)
    if finding.refusal is None:
        return _by_place(places)
    return _after_refusal(finding.refusal, setting) or _by_place(places)


ALIKE_FOR_ALL = {
    "overshadowed": "report-next-overshadowed",
    "reference_noise": "report-next-reference-noise",
    "placed": "report-next-placed",
    "switching": "report-next-switching",
}  # what is next, whatever name was refused


def _after_refusal(refusal: Refusal, setting: bool) -> Sayable | None:
    if refusal.kind == "implausible":
        if setting:
            return message("report-next-implausible", usual=usual_cause(refusal))
        return message("report-next-alike") if far_beyond(refusal) else None
    if refusal.kind == "inhomogeneous":
        return message("report-next-inhomogeneous", parts=refusal.parts or "time")
    if refusal.kind == "channel_worse" and refusal.channel is not None:
        return message("report-next-channel", channel=channel_title(CHANNELS[refusal.channel]))
    if refusal.kind in ALIKE_FOR_ALL:
        return message(ALIKE_FOR_ALL[refusal.kind])
    recording = separating_recording(refusal.name)
    return message("report-next-undetermined", recording=recording) if recording else None


def _by_place(places: tuple[Where, ...]) -> Sayable:
    return message("report-next", dimension=places[0].dimension if places else "level")


# Divides a recording into cells of time and compares the excess in each with the noise.

FINEST = 240  # cells over the run where no segment asks for more
SLIVER = 0.25  # of a cell; nearer edges are taken as one
BLOCKS = (1, 8, 64, None)  # rows averaged before they are judged; None: the whole cell
ENOUGH = 8  # rows from which the fast noise and the swing of a cell are known
STEP_TO_SIGMA = np.sqrt(np.pi) / 2.0  # mean size of a step from row to row, likewise

Parts = Sequence[np.ndarray]  # the known rows of each cell


@dataclass(frozen=True)
class ExcessCells:
    """Cells of time, k of them, and what the six channels do in each.

    edges: (k+1,) s on the unit's clock. segments: those of the recording; kinds: of each cell,
    "" between segments. excess: (6, k) standard deviations that the nominal model's misfit
    stands above noise. before, after: (6, k) mean residual without and with the findings, SI;
    swing_before, swing_after: (6, k) rms of what swings inside a cell beyond noise, SI; noise:
    (6, k) standard deviation of a mean by noise. NaN where nothing is known.
    """

    edges: np.ndarray
    segments: tuple[Segment, ...]
    kinds: tuple[str, ...]
    excess: np.ndarray
    before: np.ndarray
    after: np.ndarray
    swing_before: np.ndarray
    swing_after: np.ndarray
    noise: np.ndarray


def cells_of(explanation: Explanation) -> ExcessCells:
    """The cells of an explanation: cut at the ends of segments, and finely in between."""
    t = explanation.recording.imu.t
    segments = shown_segments(explanation.recording)
    edges = _edges(t, segments)
    middles = 0.5 * (edges[:-1] + edges[1:])
    rows = np.searchsorted(t, edges)
    rows[-1] = len(t)
    cells = [slice(*ends) for ends in pairwise(rows)]
    # A number for each cell that is the same within one segment, and between two.
    ends = sorted(end for segment in segments for end in (segment.t_start, segment.t_end))
    interval = np.unique(np.searchsorted(ends, middles), return_inverse=True)[1]
    readings = explanation.recording.imu.stack(CHANNELS)
    before, after = readings - explanation.nominal, readings - explanation.found
    after = np.where(np.isfinite(after), after, before)
    channels = []
    for i, noise in enumerate(explanation.noise):
        known = [np.arange(cell.start, cell.stop)[np.isfinite(before[cell, i])] for cell in cells]
        first, last = ([values[rows, i] for rows in known] for values in (before, after))
        channels.append(_channel(first, last, interval, float(noise)))
    kinds = [""] * len(cells)
    for segment in segments:
        first, last = np.searchsorted(middles, (segment.t_start, segment.t_end))
        kinds[first:last] = [segment.kind] * (last - first)
    return ExcessCells(edges, segments, tuple(kinds), *np.stack(channels, axis=1))


def _edges(t: np.ndarray, segments: tuple[Segment, ...]) -> np.ndarray:
    start, end = float(t[0]), float(t[-1])
    width = max(end - start, 1e-9) / FINEST
    ends = [edge for s in segments for edge in (s.t_start, s.t_end) if start < edge < end]
    kept = [start]
    for edge in [*sorted(ends), end]:
        if edge - kept[-1] >= SLIVER * width:
            pieces = int(np.ceil((edge - kept[-1]) / width))
            kept += np.linspace(kept[-1], edge, pieces + 1)[1:].tolist()
    return np.array([*kept[:-1], end] if len(kept) > 1 else [start, start + width])


def _channel(before: Parts, after: Parts, interval: np.ndarray, noise: float) -> np.ndarray:
    """(6, k): excess, mean before, after, swing before, after, noise of a mean of one channel."""
    sigmas = np.array([_fast_noise(values, noise) for values in after])
    means = [[values.mean() if len(values) else np.nan for values in parts]
             for parts in (before, after)]  # fmt: skip
    swings = [[_swing(values, s) for values, s in zip(parts, sigmas, strict=True)]
              for parts in (before, after)]  # fmt: skip
    counts = np.array([len(values) or np.nan for values in before])
    whitened, rest = ([values / s for values, s in zip(parts, sigmas, strict=True)]
                      for parts in (before, after))  # fmt: skip
    excess = _excess(whitened, rest, interval)
    return np.vstack([excess, *means, *swings, sigmas / np.sqrt(counts)])


def _fast_noise(values: np.ndarray, noise: float) -> float:
    """Standard deviation of the fast noise in a cell, from its differences; at least `noise`.

    It may be more than at rest: a table in motion shakes what stands on it.
    """
    sigma = noise if np.isfinite(noise) and noise > 0 else 0.0
    if len(values) > ENOUGH:
        sigma = max(sigma, STEP_TO_SIGMA * float(np.mean(np.abs(np.diff(values)))))
    return sigma or 1e-12


def _swing(values: np.ndarray, sigma: float) -> float:
    """rms about the mean beyond noise; 0 where chance would do as much."""
    if len(values) < ENOUGH:
        return 0.0 if len(values) else np.nan
    beyond = float(values.var()) - sigma**2
    return np.sqrt(beyond) if beyond > 4.0 * sigma**2 * np.sqrt(2.0 / len(values)) else 0.0


def _excess(whitened: Parts, rest: Parts, interval: np.ndarray) -> np.ndarray:
    """How far each cell's power exceeds that of noise, at the block length where it shows most.

    rest: the residual with the findings in the model. Noise that is not white is stronger in long
    blocks: its size there is the Allan deviation of the rest. The last and longest blocks are whole
    segments, and the time between two.
    """
    deviates = []
    for block in BLOCKS:
        size = _allan_deviation([_blocks(values, block) for values in rest])
        deviates.append([_deviate(_blocks(values, block) / size) for values in whitened])
    whole, left = (_joined(parts, interval) for parts in (whitened, rest))
    longest = max(map(len, left))
    size = _allan_deviation([_blocks(values, None) for values in left if len(values) > longest / 4])
    of_interval = np.array([_deviate(_blocks(values, None) / size) for values in whole])
    has_rows = np.array([len(values) > 0 for values in whitened])
    shown = np.array([*deviates, np.where(has_rows, of_interval[interval], np.nan)])
    largest = np.max(np.nan_to_num(shown, nan=-np.inf), axis=0)
    return np.where(np.isfinite(shown).any(axis=0), largest, np.nan)


def _joined(parts: Parts, interval: np.ndarray) -> Parts:
    """The rows of each interval."""
    return [
        np.concatenate([part for part, number in zip(parts, interval, strict=True) if number == k])
        for k in range(interval.max() + 1)
    ]


def _blocks(values: np.ndarray, block: int | None) -> np.ndarray:
    """Means of blocks times the root of their length: of variance 1 for white noise."""
    length = block or max(len(values), 1)
    count = len(values) // length
    return values[: count * length].reshape(count, length).sum(axis=1) / np.sqrt(length)


def _allan_deviation(cells: Parts) -> float:
    """Allan deviation of blocks, robust, at least 1; over cells where each holds one block."""
    steps = [np.diff(blocks) for blocks in cells if len(blocks) > 1]
    jumps = np.concatenate(steps) if steps else np.diff(np.concatenate([*cells, np.zeros(0)]))
    if not len(jumps):
        return 1.0
    return max(1.0, TO_SIGMA * float(np.median(np.abs(jumps))) / np.sqrt(2.0))


def _deviate(sums: np.ndarray) -> float:
    """The normal deviate of their chi-squared (Wilson and Hilferty, PNAS 17 (1931) 684)."""
    n = len(sums)
    if not n:
        return np.nan
    return float((np.cbrt(np.mean(sums**2)) - (1 - 2 / (9 * n))) / np.sqrt(2 / (9 * n)))


# before_after.svg: residuals without and with the findings, over time and frequency.

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
