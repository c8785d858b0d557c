"""The figures of a certificate: which there are, their captions, and how they are drawn.

What is written in a figure is the same in every language: symbols, units, axes. It is drawn as
outlines, so that the PDF needs no font for it and holds no number twice.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, get_args

from schemas.certificate import Certificate
from schemas.curve import Curve, FigureName
from tasks.certificate.figure_panels import PANELS
from tasks.rendering.chart import GREY, INK, draw
from tasks.words import Message, clauses, message

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, PANEL, FRAME = 476.0, 92.0, 34.0  # pt: of the page's text; of a row of panels; beside it
IN_A_ROW = 3
OUTLINED: dict[str, Any] = {
    "svg.fonttype": "path", "font.size": 7.0, "axes.labelsize": 7.0, "axes.titlesize": 7.5,
    "axes.labelcolor": INK, "axes.titleweight": "normal", "legend.fontsize": 7.0,
    "axes.titley": 1.0,  # nothing is above the panel: to look for it takes a fifth of the drawing
    "axes.linewidth": 0.5, "xtick.major.width": 0.5, "ytick.major.width": 0.5,
    "xtick.major.size": 2.0, "ytick.major.size": 2.0, "axes.edgecolor": GREY,
}  # fmt: skip


@dataclass(frozen=True)
class PrintedFigure:
    """A figure: its name, its title, and the sentence that says what is drawn."""

    name: FigureName
    title: Message
    caption: Message


def figures(certificate: Certificate) -> tuple[PrintedFigure, ...]:
    """Every figure for which there are curves, in the order in which they are printed."""
    found = []
    for name in get_args(FigureName):
        curves = of_figure(certificate, name)
        if curves:
            earlier = tuple(dict.fromkeys(label for curve in curves for label in curve.labels))
            of_history = {"certificates": clauses(earlier)} if name == "history" else {}
            caption = message(f"certificate-figure.{name}-caption", **of_history)
            title = message(f"certificate-figure.{name}")
            found.append(PrintedFigure(name, title, caption))
    return tuple(found)


def of_figure(certificate: Certificate, name: FigureName) -> tuple[Curve, ...]:
    """The curves of one figure."""
    return tuple(curve for curve in certificate.curves if curve.figure == name)


def drawn(certificate: Certificate) -> dict[str, str]:
    """Each figure as SVG, by its name; the same curves give the same bytes."""
    day = certificate.calibrated_on
    return {
        each.name: _svg(each.name, of_figure(certificate, each.name), day.toordinal() if day else 0)
        for each in figures(certificate)
    }


@lru_cache(maxsize=32)  # draft, check and issue draw the same ones
def _svg(name: FigureName, curves: tuple[Curve, ...], day: int) -> str:
    """day: of the calibration, days since year 1, from which a history counts."""
    by_axis = name in ("rate-residuals", "tumble")
    # The curves of each panel: of one axis, or of one quantity.
    keys = [curve.axis if by_axis else curve.quantity for curve in curves]
    panels = [
        tuple(curve for curve, key in zip(curves, keys, strict=True) if key == one)
        for one in dict.fromkeys(keys)
    ]
    columns = min(len(panels), IN_A_ROW if len(panels) != IN_A_ROW + 1 else 2)
    rows = -(-len(panels) // columns)
    height = rows * PANEL + (rows - 1) * FRAME + FRAME

    def content(figure: "Figure") -> None:
        figure.set_layout_engine("none")  # it would cost as much again as the drawing
        grid = figure.subplots(rows, columns, squeeze=False, gridspec_kw={
            "left": 40 / WIDTH, "right": 1 - 14 / WIDTH, "bottom": 22 / height,
            "top": 1 - 12 / height, "wspace": 0.28, "hspace": FRAME / PANEL,
        })  # fmt: skip
        for axes, panel in zip(grid.flat, panels, strict=False):
            PANELS[name](axes, panel, day)
        for unused in grid.flat[len(panels) :]:
            unused.set_axis_off()

    return draw(name, WIDTH, height, content, OUTLINED)
