"""Pages and charts: templates in every language, every file complete in itself.

`templates/base.html` has the style, and each user of it a folder of templates of its own.
"""

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from html import escape
from io import StringIO
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any
from unicodedata import east_asian_width

import numpy as np

from tasks.words import LANGUAGES, MAIN, Sayable, message, say, texts

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BASE = Path(__file__).parent / "templates"


def page(template: Path, **values: Any) -> str:
    """The HTML of a template that extends base.html, which needs nothing from elsewhere.

    Templates have `say(id, …)` for a message of the catalogues, and the filter `text` for anything
    sayable; both are escaped.
    """
    return _environment(template.parent).get_template(template.name).render(**values) + "\n"


@cache
def _environment(folder: Path) -> "Environment":
    """Compiles each template of a folder once."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # late: only pages need them

    environment = Environment(
        loader=FileSystemLoader([folder, BASE]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"text": _text}
    names = texts(message("language-name"))
    environment.globals |= {"say": _message, "languages": LANGUAGES, "language_name": names}
    return environment


def inline(svg: str) -> "Markup":
    """A chart embedded in a page unchanged."""
    from markupsafe import Markup

    return Markup(svg)


def inline_each(by_language: Mapping[str, str]) -> "Markup":
    """A chart in every language, of which the page shows one."""
    from markupsafe import Markup

    span = Markup('<span lang="{}">{}</span>')
    return Markup("").join(
        span.format(language, Markup(svg)) for language, svg in by_language.items()
    )


def _text(phrase: Sayable) -> "Markup":
    """In every language, of which the page shows one; once where all are the same."""
    from markupsafe import Markup

    if hasattr(phrase, "__html__"):
        return Markup(phrase)
    by_language = texts(phrase)
    if len(set(by_language.values())) == 1:
        return Markup("{}").format(by_language[LANGUAGES[0]])
    span = Markup('<span lang="{}">{}</span>')
    return Markup("").join(span.format(language, text) for language, text in by_language.items())


def _message(id_: str, **arguments: Any) -> "Markup":
    return _text(message(id_, **arguments))


# SVG charts in one style, with text as text and reproducible to the byte.


INK, GREY, PALE = "#222222", "#666666", "#e4e4e4"
BEFORE, AFTER = "#d55e00", "#0072b2"  # Okabe and Ito: also for colour-blind readers
FINDINGS = ("#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#6a3d9a")
CHINESE_FONTS = ("PingFang SC", "Microsoft YaHei", "Noto Sans SC", "WenQuanYi Zen Hei")
LETTER, WIDE_LETTER = 7.5, 12.0  # px at the usual size
STYLE: Any = {
    "svg.fonttype": "none",  # text stays text; measured with the font that matplotlib ships
    "font.sans-serif": ["DejaVu Sans", "Helvetica", "Arial", *CHINESE_FONTS],
    "font.size": 12.0, "axes.titlesize": 13.0, "axes.titleweight": "bold",
    "axes.titlelocation": "left", "axes.labelsize": 12.0, "axes.labelcolor": GREY,
    "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": INK,
    "text.color": INK, "xtick.color": INK, "ytick.color": INK,
    "legend.frameon": False, "legend.fontsize": 12.0, "figure.constrained_layout.use": True,
    "figure.constrained_layout.w_pad": 0.14, "figure.constrained_layout.h_pad": 0.1,
}  # fmt: skip
NO_STYLE: Any = MappingProxyType({})
CLOCKS = (("h", 3600.0), ("min", 60.0), ("s", 1.0))
NO_METADATA = dict.fromkeys(("Creator", "Date", "Format", "Type"))


@dataclass(frozen=True, eq=False)
class Envelope:
    """Of each bin the smallest and the largest value.

    t: (m,) s, the time of the first row of the bin; low, high: (m,), NaN where no row of the bin
    has a number. is_reduced: whether a bin may hold more than one row.
    """

    t: np.ndarray
    low: np.ndarray
    high: np.ndarray
    is_reduced: bool


def draw(
    title: str,
    width: float,
    height: float,
    content: "Callable[[Figure], None]",
    style: Any = NO_STYLE,
) -> str:
    """SVG of a figure of width × height px; the title is what a screen reader says.

    content: draws into the figure by matplotlib's objects. style: otherwise than STYLE.
    """
    # Late: only drawing needs it, and it takes a quarter of a second.
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    written = StringIO()
    with (
        rc_context({**STYLE, **style, "svg.hashsalt": title}),
        warnings.catch_warnings(),
    ):
        # The reader has a font for Chinese; the one that matplotlib measures with lacks it.
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        figure = Figure(figsize=(width / 72.0, height / 72.0))
        content(figure)
        # Figure.savefig would draw everything twice.
        FigureCanvasSVG(figure).print_svg(written, metadata=NO_METADATA)
    svg = written.getvalue()
    body = svg[svg.index("<svg") + len("<svg") :].replace('pt"', '"', 2)  # points are px here
    return f'<svg role="img" aria-label="{escape(title)}"{body}'


def picture_file(name: str, language: str) -> str:
    """`where.svg` in the main language, `where-LANGUAGE.svg` in another."""
    return f"{name}.svg" if language == MAIN else f"{name}-{language}.svg"


def text_width(text: str) -> float:
    """px, about, at the usual size."""
    return sum(WIDE_LETTER if east_asian_width(each) in "FW" else LETTER for each in text)


def time_axis(axes: "Axes", language: str) -> None:
    """Ticks of an axis of seconds in h, min or s, by the length of the run."""
    from matplotlib.ticker import MaxNLocator

    start, end = axes.get_xlim()
    unit, size = next(clock for clock in CLOCKS if end - start > 3.0 * clock[1] or clock[0] == "s")
    ticks = MaxNLocator(10, steps=[1, 2, 5, 10]).tick_values(start / size, end / size)
    inside = [tick for tick in ticks if start <= tick * size <= end]
    axes.set_xticks([tick * size for tick in inside], [f"{tick:g}" for tick in inside])
    axes.set_xlabel(say(message("chart-time", unit=unit), language), loc="right")


def envelope(t: np.ndarray, values: np.ndarray, bins: int) -> Envelope:
    """The envelope of a signal over equal times.

    t: (n,) s, strictly rising; values: (n,). With no more than two rows per bin every row is kept.
    A bin without rows, in a gap of the recording, is left out.
    """
    if len(t) <= 2 * bins:
        return Envelope(t, values, values, is_reduced=False)
    edges = np.linspace(t[0], t[-1], bins + 1)[:-1]
    starts = np.unique(np.searchsorted(t, edges))
    low = np.fmin.reduceat(values, starts)
    high = np.fmax.reduceat(values, starts)
    return Envelope(t[starts], low, high, is_reduced=True)
