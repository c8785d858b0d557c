"""The report of `make bench`: one table for each section, and the picture of two of them."""

import platform
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tasks.rendering import AFTER, BEFORE, INK, PALE, draw
from tasks.version import code_version
from tests.bench.measure import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, ROW, AROUND = 900, 34, 110  # px


def markdown(sections: Sequence[Section]) -> str:
    """Every figure with its ratio to the first of its section, and what was asked."""
    lines = [
        "# Speed", "",
        f"{code_version()}, Python {platform.python_version()}, {platform.machine()}. Processor "
        "time of one thread where nothing else is said; ratios are to the first line of each "
        "table, measured in the same run.", "",
    ]  # fmt: skip
    for section in sections:
        ratio = "times as fast" if section.faster else "times the first"
        lines += [f"## {section.title}", "", f"| | ms | {ratio} | asked |", "|---|--:|--:|--:|"]
        for figure in section.figures:
            asked = "" if figure.asked is None else f"{figure.asked:g}"
            lines.append(
                f"| {figure.name} | {1e3 * figure.seconds:.1f} | {section.ratio(figure):.2f} "
                f"| {asked} |"
            )
        lines += ["", section.note, ""] if section.note else [""]
    return "\n".join(lines)


def picture(section: Section) -> str:
    """SVG: how long each figure of a section takes, over the first."""

    def content(figure: "Figure") -> None:
        axes = figure.subplots()
        ratios = [section.ratio(each) for each in section.figures]
        names = [each.name.replace("`", "") for each in section.figures]
        colours = [BEFORE, *[AFTER] * (len(ratios) - 1)]
        bars = axes.barh(range(len(ratios)), ratios, color=colours, height=0.6)
        axes.bar_label(bars, [f"{ratio:.1f} ×" for ratio in ratios], padding=4, color=INK)
        axes.set_yticks(range(len(ratios)), names)
        axes.invert_yaxis()
        axes.grid(axis="x", color=PALE)
        axes.set_axisbelow(True)
        axes.tick_params(length=0)
        axes.margins(x=0.12)
        axes.spines[["left", "bottom"]].set_visible(False)

    height = AROUND + ROW * len(section.figures)
    return draw(section.title, WIDTH, height, content)


def write(sections: Sequence[Section], folder: Path) -> None:
    """speed.md, and speed.svg of the first section."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "speed.md").write_text(markdown(sections), encoding="utf-8")
    (folder / "speed.svg").write_text(picture(sections[0]), encoding="utf-8")
