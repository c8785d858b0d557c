"""A small chart with two axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tasks.rendering.chart import PALE, draw

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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

    def content(figure: "Figure") -> None:
        axes = figure.subplots()
        for line in series:
            style = "o" if line.dots else "-"
            axes.errorbar(line.x, line.y, line.bars, fmt=style, color=line.colour, markersize=7,
                          linewidth=1.8, elinewidth=1.4, label=line.name)  # fmt: skip
        for mark in marks:
            draw_line = axes.axhline if mark.across else axes.axvline
            draw_line(mark.at, color=mark.colour, linewidth=1.6, label=mark.name or None)
        axes.set_xlabel(x_name, loc="right")
        axes.set_ylabel(y_name, loc="top")
        axes.grid(axis="y", color=PALE)
        axes.set_axisbelow(True)
        axes.spines["left"].set_visible(False)
        figure.legend(loc="outside upper left", ncols=len(series) + len(marks))

    return draw(title, 760, 356, content)
