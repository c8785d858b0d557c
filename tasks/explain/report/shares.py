"""shares.svg: the share of the mismatch that each finding removes, and the rest by channel."""

from typing import TYPE_CHECKING, Any

from schemas.discrepancy import Discrepancy
from tasks.explain.channels import CHANNELS
from tasks.explain.evidence.shares import MOSTLY_NOISE
from tasks.explain.report.names import capital, short_channel_title
from tasks.rendering.chart import AFTER, BEFORE, FINDINGS, GREY, LETTER, draw, text_width
from tasks.words import message, say
from tasks.words.quantities import chi2, percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

WIDTH, HEAD, FOOT, ROW = 1040, 48, 22, 30  # px
SHARE_BARS, CHANNEL_BARS = (30, 230), (790, 980)  # px
MAX_TITLE = 405  # px of a title beside a bar
REST = "#b8b8b8"
BAR = 0.62  # of a row


def shares_svg(discrepancy: Discrepancy, language: str) -> str:
    """The picture, its words in a language."""
    bars = share_bars(discrepancy, language)
    rows = max(len(bars), len(CHANNELS))
    height = HEAD + ROW * rows + FOOT

    def content(figure: "Figure") -> None:
        figure.set_layout_engine("none")
        bottom, top = FOOT / height, ROW * rows / height
        left, right = (
            figure.add_axes((start / WIDTH, bottom, (end - start) / WIDTH, top))
            for start, end in (SHARE_BARS, CHANNEL_BARS)
        )
        _draw_shares(left, bars, rows)
        left.set_title(say(message("chart-shares"), language), fontsize=15, pad=10)
        _draw_left_over(right, discrepancy, rows, language)

    return draw(say(message("chart-shares.title"), language), WIDTH, height, content)


def share_bars(discrepancy: Discrepancy, language: str) -> list[tuple[str, float, str]]:
    """(title, share of the mismatch, colour) of each finding, and of what none explains."""
    bars = [
        (
            say(capital(finding.title), language),
            finding.share,
            FINDINGS[k] if k < len(FINDINGS) else GREY,
        )
        for k, finding in enumerate(discrepancy.findings)
    ]
    rest = say(message("chart-not-explained"), language)
    return [*bars, (rest, 1.0 - discrepancy.explained_share, REST)]


def _draw_shares(axes: Any, bars: list[tuple[str, float, str]], rows: int) -> None:
    axes.set(xlim=(0.0, 1.0), ylim=(rows, 0))
    for row, (title, share, colour) in enumerate(bars):
        axes.barh(row + 0.5, 1.0, BAR, color="#f5f5f5")
        axes.barh(row + 0.5, min(max(share, 0.0), 1.0), BAR, color=colour)
        words = f"{percent(share)}  {_cut(title)}"
        axes.annotate(words, (1, row + 0.5), xytext=(8, 0), va="center",
                      textcoords="offset points", fontsize=12)  # fmt: skip
    axes.set_axis_off()


def _cut(title: str) -> str:
    """What there is room for."""
    if text_width(title) <= MAX_TITLE:
        return title
    while text_width(title) > MAX_TITLE - LETTER:
        title = title[:-1]
    return title + "…"


def _draw_left_over(axes: Any, discrepancy: Discrepancy, rows: int, language: str) -> None:
    values = [discrepancy.left_over.get(channel) for channel in CHANNELS]
    largest = max([2.0, *(value for value in values if value is not None)])
    smallest = min([0.5, *(value for value in values if value)])
    axes.set(xlim=(smallest, 1.3 * largest), ylim=(rows, 0), xscale="log")
    axes.axvline(1.0, color=GREY, linewidth=1)
    alone, unknown = (
        say(message(id_), language) for id_ in ("chart-noise-alone", "chart-not-known")
    )
    axes.annotate(alone, (1.0, rows), xytext=(0, -12), color=GREY, fontsize=11,
                  textcoords="offset points", ha="center", va="center")  # fmt: skip
    for row, (channel, value) in enumerate(zip(CHANNELS, values, strict=True)):
        title = say(short_channel_title(channel), language)
        axes.annotate(title, (0, row + 0.5), xycoords=("axes fraction", "data"), xytext=(-8, 0),
                      textcoords="offset points", ha="right", va="center")  # fmt: skip
        if value is None:
            axes.annotate(unknown, (1.0, row + 0.5), xytext=(6, 0), color=GREY, va="center",
                          textcoords="offset points")  # fmt: skip
            continue
        axes.barh(
            row + 0.5, value - 1.0, BAR, left=1.0, color=BEFORE if value >= MOSTLY_NOISE else AFTER
        )
        axes.annotate(chi2(value), (max(value, 1.0), row + 0.5), xytext=(6, 0), va="center",
                      textcoords="offset points")  # fmt: skip
    axes.set_title(say(message("chart-left-over"), language), fontsize=15, pad=10, x=-0.65)
    axes.set_axis_off()
