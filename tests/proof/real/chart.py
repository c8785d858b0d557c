"""A small chart with two axes, drawn with the report's shapes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tasks.explain.report.svg import (
    GREY,
    INK,
    PALE,
    label,
    line,
    path,
    picture,
    rect,
    ticks,
    width_of,
)

WIDTH, LEFT, END, TOP, PLOT = 760.0, 76.0, 740.0, 56.0, 250.0


@dataclass(frozen=True)
class Series:
    """Points (n,) and (n,); bars: half lengths (n,). A line, or dots with their bars."""

    name: str
    x: np.ndarray
    y: np.ndarray
    colour: str
    dots: bool = False
    bars: np.ndarray | None = None


@dataclass(frozen=True)
class Mark:
    """An upright (across=False) or level line with its words."""

    name: str
    at: float
    colour: str
    across: bool = False


def chart(
    title: str, x_name: str, y_name: str, series: Sequence[Series], marks: Sequence[Mark] = ()
) -> str:
    """The picture, with its axes from the least to the largest of what is drawn."""
    xs = np.concatenate([each.x for each in series] + [[m.at] for m in marks if not m.across])
    ys = np.concatenate(
        [each.y + sign * (0.0 if each.bars is None else each.bars) for each in series
         for sign in (-1.0, 1.0)]
        + [[m.at] for m in marks if m.across]
    )  # fmt: skip
    across, up = _span(xs, 0.03), _span(ys, 0.08)

    def place(x: float, y: float) -> tuple[float, float]:
        return (
            LEFT + (x - across[0]) / (across[1] - across[0]) * (END - LEFT),
            TOP + PLOT * (1.0 - (y - up[0]) / (up[1] - up[0])),
        )

    parts = []
    for tick in ticks(*up):
        y = place(across[0], tick)[1]
        parts += [line(LEFT, y, END, y, PALE), label(LEFT - 8, y + 4, f"{tick:g}", 12, "end")]
    for tick in ticks(*across, 8):
        x = place(tick, up[0])[0]
        parts += [line(x, TOP + PLOT, x, TOP + PLOT + 5, INK)]
        parts.append(label(x, TOP + PLOT + 20, f"{tick:g}", 12, "middle"))
    parts.append(line(LEFT, TOP + PLOT, END, TOP + PLOT, INK))
    parts.append(label(END, TOP + PLOT + 40, x_name, 12, "end", GREY))
    parts.append(label(4, TOP - 12, y_name, 12, "start", GREY))
    for mark in marks:
        x, y = place(across[0] if mark.across else mark.at, mark.at if mark.across else up[0])
        ends = (LEFT, y, END, y) if mark.across else (x, TOP, x, TOP + PLOT)
        parts.append(line(*ends, mark.colour, 1.6))
    for each in series:
        points = [place(float(x), float(y)) for x, y in zip(each.x, each.y, strict=True)]
        if not each.dots:
            parts.append(path(points, each.colour, 1.8))
            continue
        for k, (x, y) in enumerate(points):
            if each.bars is not None:
                low, high = (place(0.0, each.y[k] + s * each.bars[k])[1] for s in (-1, 1))
                parts.append(line(x, low, x, high, each.colour, 1.4))
            parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{each.colour}"/>')
    legend = [(each.name, each.colour) for each in series]
    legend += [(mark.name, mark.colour) for mark in marks if mark.name]
    return picture(WIDTH, TOP + PLOT + 50, title, [*parts, *_legend(legend)])


def _legend(entries: Sequence[tuple[str, str]]) -> list[str]:
    parts, at = [], LEFT
    for words, colour in entries:
        parts += [rect(at, 10, 12, 12, colour), label(at + 17, 21, words)]
        at += 34 + width_of(words)
    return parts


def _span(values: np.ndarray, margin: float) -> tuple[float, float]:
    low, high = float(np.min(values)), float(np.max(values))
    more = margin * ((high - low) or 1.0)
    return low - more, high + more
