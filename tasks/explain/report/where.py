"""where.svg: six channels over the time of the run, dark where the standard's model misfits."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from schemas.discrepancy import Discrepancy, FindingSaid
from schemas.recording import MEASURED, Segment
from tasks.explain.explanation import CHANNELS
from tasks.explain.report.excess import Cells
from tasks.explain.report.svg import (
    FINDINGS,
    GREY,
    INK,
    PALE,
    Scale,
    hours_or_minutes,
    label,
    line,
    picture,
    rect,
    ticks,
    width_of,
)
from tasks.explain.report.words import capital, channel_name, effect_name, percent, text_of

WIDTH, LEFT, RIGHT = 1200, 120, 1060
TOP, ROW, BAR = 76, 50, 6
CELL = 32  # height of a row's cells; bars of the findings stand below
CLASSES = (4.0, 8.0, 16.0, 32.0, 64.0)  # standard deviations above noise
COLOURS = ("#fbfbf6", "#fee391", "#fec44f", "#fe9929", "#d95f0e", "#7f2704")
KINDS = {"static": "#9aa5ad", "rate": "#33658a", "rotation": "#86bbd8"}
KIND_WORDS = {"static": "rests", "rate": "rate", "rotation": "turn"}
UNLABELLED = "#f0f0f0"
MOST = 5  # findings that are marked


def where_svg(discrepancy: Discrepancy, cells: Cells) -> str:
    """The picture; its words are English with the field's symbols."""
    start, end = float(cells.edges[0]), float(cells.edges[-1])
    segments = cells.segments

    def x(t: float) -> float:
        return LEFT + (min(max(t, start), end) - start) / (end - start) * (RIGHT - LEFT)

    findings = discrepancy.findings[:MOST]
    bottom = TOP + ROW * len(CHANNELS)
    parts = [
        label(LEFT, 20, "Where the standard's model misfits the recording", 16, bold=True),
        *_kind_strip(segments, x),
        *_rows(cells, x),
        *_marks(findings, segments, x, (start, end)),
        *_time_axis(start, end, x, bottom),
        *_colour_legend(bottom + 62, segments),
        *_finding_legend(findings, bottom + 96),
    ]
    height = bottom + 84 + 22 * len(findings)
    return picture(WIDTH, height, "Excess of six channels over the time of the run", parts)


def _kind_strip(segments: Sequence[Segment], x: Scale) -> list[str]:
    parts = [rect(LEFT, TOP - 20, RIGHT - LEFT, 10, UNLABELLED)]
    measured = [s for s in segments if s.kind in MEASURED]
    for segment in measured:
        wide = max(x(segment.t_end) - x(segment.t_start), 0.5)
        parts.append(rect(x(segment.t_start), TOP - 20, wide, 10, KINDS[segment.kind]))
    for words, group in groupby(measured, key=_group):
        stretch = list(group)
        a, b = x(stretch[0].t_start), x(stretch[-1].t_end)
        if b - a > width_of(words) + 6:
            parts.append(label((a + b) / 2, TOP - 28, words, 13, "middle", GREY))
    return parts


def _group(segment: Segment) -> str:
    words = KIND_WORDS[segment.kind]
    return words if segment.kind == "static" else f"{words} {segment.axis}"


def _rows(cells: Cells, x: Scale) -> list[str]:
    parts = []
    for i, channel in enumerate(CHANNELS):
        y = TOP + ROW * i
        parts.append(label(LEFT - 10, y + CELL / 2 + 5, channel_name(channel)[0].replace(
            "accelerometer", "accel."), 14, "end"))  # fmt: skip
        colours = [_colour(value) for value in cells.excess[i]]
        at = 0
        for colour, group in groupby(colours):
            upto = at + len(list(group))
            a, b = x(cells.edges[at]), x(cells.edges[upto])
            parts.append(rect(a, y, b - a + 0.15, CELL, colour))
            at = upto
        parts.append(line(LEFT, y, RIGHT, y, "#cccccc", 0.6))
        parts.append(line(LEFT, y + CELL, RIGHT, y + CELL, "#cccccc", 0.6))
    return parts


def _colour(excess: float) -> str:
    return PALE if np.isnan(excess) else COLOURS[int(np.searchsorted(CLASSES, excess, "right"))]


def _marks(
    findings: Sequence[FindingSaid], segments: Sequence[Segment], x: Scale, run: tuple[float, float]
) -> list[str]:
    """Bars below each row where a finding sits, and its share at the right end."""
    spans = {s.name: (s.t_start, s.t_end) for s in segments}
    parts = []
    taken = dict.fromkeys(CHANNELS, 0)
    for n, finding in enumerate(findings):
        colour = FINDINGS[n]
        for channel in dict.fromkeys(each.channel for each in finding.where):
            if channel not in taken:  # several at once, with little in each
                continue
            entries = [each for each in finding.where if each.channel == channel]
            names = [name for each in entries for name in each.segments if name in spans]
            y = TOP + ROW * CHANNELS.index(channel) + CELL + 2 + (BAR - 1) * (taken[channel] % 3)
            for a, b in [spans[name] for name in names] or [run]:
                parts.append(rect(x(a), y, max(x(b) - x(a), 1.5), BAR - 2, colour))
            at = RIGHT + 12 + 62 * (taken[channel] % 2)
            down = TOP + ROW * CHANNELS.index(channel) + 14 + 18 * (taken[channel] // 2)
            parts += _number(at + 8, down, n)
            parts.append(label(at + 20, down + 5, percent(sum(e.share for e in entries)), 12))
            taken[channel] += 1
    return parts


def _number(x: float, y: float, n: int) -> list[str]:
    disc = f'<circle cx="{x:.1f}" cy="{y:.1f}" r="8.5" fill="{FINDINGS[n]}"/>'
    return [disc, label(x, y + 4, str(n + 1), 12, "middle", "#ffffff", True)]


def _time_axis(start: float, end: float, x, y: float) -> list[str]:  # type: ignore[no-untyped-def]
    unit, size = hours_or_minutes(end - start)
    parts = [line(LEFT, y, RIGHT, y, INK)]
    for tick in ticks(start / size, end / size, 10):
        at = x(tick * size)
        parts += [line(at, y, at, y + 5, INK), label(at, y + 19, f"{tick:g}", 13, "middle")]
    parts.append(label(RIGHT + 12, y + 19, f"time / {unit}", 13))
    return parts


def _colour_legend(y: float, segments: Sequence[Segment]) -> list[str]:
    parts = [label(4, y, "excess over noise", 13, "start", GREY)]
    at = float(LEFT)
    words = ["none", *(f"> {c:g} σ" for c in CLASSES)]
    for colour, word in zip((*COLOURS, PALE), (*words, "not known"), strict=True):
        parts.append(rect(at, y - 13, 22, 16, colour))
        parts.append(
            f'<rect x="{at:.1f}" y="{y - 13:.1f}" width="22" height="16" fill="none" '
            'stroke="#bbbbbb" stroke-width="0.6"/>'
        )
        parts.append(label(at + 28, y, word, 13))
        at += 44 + width_of(word)
    at += 24
    there = {segment.kind for segment in segments}
    for kind, colour in ((k, c) for k, c in KINDS.items() if k in there):
        parts += [rect(at, y - 9, 22, 8, colour), label(at + 28, y, kind, 13)]
        at += 44 + width_of(kind)
    return parts


def _finding_legend(findings: Sequence[FindingSaid], y: float) -> list[str]:
    parts = []
    for n, finding in enumerate(findings):
        title = capital(text_of(finding.title))[0] or effect_name(finding.effect)[0]
        parts += _number(LEFT + 8, y + 22 * n - 4, n)
        parts.append(label(LEFT + 24, y + 22 * n, f"{title} ({finding.effect})", 14))
    return parts
