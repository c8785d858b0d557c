"""Pictures written by hand: the few shapes that the report draws, as text of SVG."""

from collections.abc import Callable, Sequence
from html import escape
from math import floor, log10

import numpy as np

Scale = Callable[[float], float]  # from a quantity to a place in the picture

INK, GREY, PALE = "#222222", "#666666", "#e4e4e4"
BEFORE, AFTER = "#d55e00", "#0072b2"  # Okabe and Ito: told apart by every eye, and in print
FINDINGS = ("#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#6a3d9a")
FONT = "Helvetica, Arial, 'Noto Sans', sans-serif"
WIDE = 0.56  # of the size of a letter: its mean width


def picture(width: float, height: float, title: str, parts: Sequence[str]) -> str:
    """A whole picture; the title is what a screen reader says."""
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
            f'width="100%" role="img" font-family="{FONT}">',
            f"<title>{escape(title)}</title>",
            rect(0, 0, width, height, "#ffffff"),
            *parts,
            "</svg>\n",
        ]
    )


def rect(x: float, y: float, w: float, h: float, fill: str, opacity: float = 1.0) -> str:
    """A filled rectangle."""
    seen = f' fill-opacity="{opacity:g}"' if opacity < 1 else ""
    return f'<rect x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}" fill="{fill}"{seen}/>'


def line(x1: float, y1: float, x2: float, y2: float, colour: str = GREY, width: float = 1.0) -> str:
    """A straight line."""
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{colour}" '
        f'stroke-width="{width:g}"/>'
    )


def path(points: Sequence[tuple[float, float]], colour: str, width: float = 1.5) -> str:
    """A line through points; begun anew behind a point that is not finite."""
    steps, pen = [], "M"
    for x, y in points:
        if np.isfinite(x) and np.isfinite(y):
            steps.append(f"{pen}{x:.1f} {y:.1f}")
            pen = "L"
        else:
            pen = "M"
    return (
        f'<path d="{" ".join(steps)}" fill="none" stroke="{colour}" stroke-width="{width:g}" '
        'stroke-linejoin="round"/>'
    )


def label(
    x: float, y: float, words: str, size: float = 13, anchor: str = "start", colour: str = INK,
    bold: bool = False,
) -> str:  # fmt: skip
    """Words; y is their base line."""
    weight = ' font-weight="bold"' if bold else ""
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" font-size="{size:g}" text-anchor="{anchor}" '
        f'fill="{colour}"{weight}>{escape(words)}</text>'
    )


def width_of(words: str, size: float = 13) -> float:
    """About how wide words are."""
    return WIDE * size * len(words)


def ticks(low: float, high: float, most: int = 6) -> list[float]:
    """Round numbers between two bounds, `most` at the most."""
    if not high > low:
        return [low]
    rough = (high - low) / most
    power = 10.0 ** floor(log10(rough))
    step = next(power * m for m in (1, 2, 5, 10) if power * m >= rough * 0.999)
    first = np.ceil(low / step - 1e-9)
    return [float(step * (first + i)) + 0.0 for i in range(int((high - low) / step + 1e-9) + 1)
            if step * (first + i) <= high + 1e-9 * step]  # fmt: skip


def hours_or_minutes(seconds: float) -> tuple[str, float]:
    """The unit that a run of this length is read in, and its length in s."""
    if seconds > 3 * 3600.0:
        return "h", 3600.0
    return ("min", 60.0) if seconds > 180.0 else ("s", 1.0)
