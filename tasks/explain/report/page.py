"""Writes the report folder: a page, its charts, the result and the prediction as data."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from schemas.base import Unusable
from schemas.discrepancy import Discrepancy, ReportedFinding
from schemas.recording import MEASURED, Segment
from tasks.explain.explanation import CHANNELS, UNNAMED, Explanation
from tasks.explain.report import statements
from tasks.explain.report.discrepancy import ExcessCells, before_after_svg, cells_of
from tasks.explain.report.statements import capital, short_channel_title
from tasks.explain.report.verdict import detected, shares_svg, small_remainders, tested
from tasks.rendering import (
    FINDINGS,
    GREY,
    PALE,
    draw,
    inline_each,
    page,
    picture_file,
    text_width,
    time_axis,
)
from tasks.version import code_version
from tasks.words import LANGUAGES, message, say
from tasks.words.numbers import USUAL_K, chi2, percent, quantities

if TYPE_CHECKING:
    from matplotlib.figure import Figure


TEMPLATE = Path(__file__).parent / "templates" / "report.html"
BADGES = {"no_mismatch": "good", "explained": "good", "partly_explained": "part",
          "unexplained": "bad"}  # fmt: skip


def write_report(
    discrepancy: Discrepancy, explanation: Explanation, folder: Path
) -> tuple[Path, ...]:
    """Writes report.html, report.json, its pictures and prediction.parquet.

    Each file appears whole or not at all; the page comes last. Returns their paths. Raises
    Unusable where the folder cannot be written.
    """
    pictures = pictures_of(discrepancy, explanation)
    contents = {
        "prediction.parquet": _prediction(explanation),
        **{
            picture_file(name, language): picture.encode()
            for name, by_language in pictures.items()
            for language, picture in by_language.items()
        },
        "report.json": (discrepancy.model_dump_json(indent=1) + "\n").encode(),
        "report.html": report_html(discrepancy, explanation, pictures).encode(),
    }
    return tuple(_appear(folder, name, content) for name, content in contents.items())[::-1]


def pictures_of(discrepancy: Discrepancy, explanation: Explanation) -> dict[str, dict[str, str]]:
    """The pictures of a report, SVG by name and language."""
    cells = cells_of(explanation)
    drawn: dict[str, Callable[[str], str]] = {
        "where": partial(where_svg, discrepancy, cells),
        "before_after": partial(before_after_svg, explanation, cells),
        "shares": partial(shares_svg, discrepancy),
    }
    return {name: {language: of(language) for language in LANGUAGES} for name, of in drawn.items()}


def report_html(
    discrepancy: Discrepancy,
    explanation: Explanation,
    pictures: Mapping[str, Mapping[str, str]],
) -> str:
    """The HTML of a report: one file, every language, with its pictures in it."""
    return page(
        TEMPLATE,
        title=say(message("report-title", recording=discrepancy.recording_id), LANGUAGES[0]),
        discrepancy=discrepancy,
        badge=BADGES[discrepancy.verdict],
        **{name: inline_each(picture) for name, picture in pictures.items()},
        small=small_remainders(discrepancy),
        colours=dict(enumerate(FINDINGS)),
        other_colour=GREY,
        names=statements,
        statements=statements,
        coverage=USUAL_K,
        quantities=quantities,
        percent=percent,
        chi2=chi2,
        tested=tested(explanation.recording),
        detected=detected(discrepancy.detection),
        recording=explanation.recording,
        code_version=code_version(),
    )


def _appear(folder: Path, name: str, content: bytes) -> Path:
    """Writes a file under another name first, then gives it its own; makes the folder.

    Raises Unusable where the disk refuses.
    """
    path, draft = folder / name, folder / f".{name}.part"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        draft.write_bytes(content)
        draft.replace(path)
    except OSError as error:
        raise Unusable(
            f"{path} cannot be written ({error.strerror or error}); name another folder with "
            "--out, or free some space and grant access."
        ) from error
    finally:
        if draft.is_file():
            draft.unlink()
    return path


def _prediction(explanation: Explanation) -> bytes:
    """prediction.parquet: t (s), and each channel's nominal and found reading, rad/s and m/s².

    One row for each row of the unit's stream; NaN where the motion is not known.
    """
    columns = {"t": explanation.recording.imu.t}
    for i, channel in enumerate(CHANNELS):
        columns[f"{channel}_nominal"] = explanation.nominal[:, i]
        columns[f"{channel}_found"] = explanation.found[:, i]
    arrays = {name: np.ascontiguousarray(each, float) for name, each in columns.items()}
    sink = pa.BufferOutputStream()
    pq.write_table(pa.table(arrays), sink, compression="zstd")
    return bytes(sink.getvalue().to_pybytes())


# where.svg: six channels over the run, dark where the standard's model does not fit.

WIDTH, LEFT, RIGHT, TOP, ROW = 1040, 128, 896, 84, 50  # px
THRESHOLDS = (4.0, 8.0, 16.0, 32.0, 64.0)  # standard deviations above noise
COLOURS = ("#fbfbf6", "#fee391", "#fec44f", "#fe9929", "#d95f0e", "#7f2704", PALE)
KINDS = {"static": "#9aa5ad", "rate": "#33658a", "rotation": "#86bbd8"}
UNLABELLED = "#f0f0f0"
CELL, BAR = 0.66, 0.09  # heights in rows: of a channel's cells, of a finding's bar below them
STRIP, TITLES = -0.5, -0.58  # in rows: the strip of segments, and what stands above it


def where_svg(discrepancy: Discrepancy, cells: ExcessCells, language: str) -> str:
    """The picture, its words in a language."""
    findings = discrepancy.findings[: len(FINDINGS)]
    bottom = 88 + 24 * len(findings)
    height = TOP + ROW * len(CHANNELS) + bottom

    def content(figure: "Figure") -> None:
        figure.set_layout_engine("none")
        axes = figure.add_axes((LEFT / WIDTH, bottom / height, (RIGHT - LEFT) / WIDTH,
                                ROW * len(CHANNELS) / height))  # fmt: skip
        axes.set(xlim=(cells.edges[0], cells.edges[-1]), ylim=(len(CHANNELS), 0))
        axes.spines["left"].set_visible(False)
        names = [say(short_channel_title(c), language) for c in CHANNELS]
        axes.set_yticks(np.arange(len(CHANNELS)) + CELL / 2, names)
        axes.tick_params(axis="y", length=0)
        time_axis(axes, language)
        axes.set_title(say(message("chart-where"), language), pad=52, fontsize=15)
        _segment_strip(axes, cells.segments, language)
        _cells(axes, cells)
        _findings(axes, findings, cells, language)
        _colour_legend(axes, cells, language)

    return draw(say(message("chart-where.title"), language), WIDTH, height, content)


def _segment_strip(axes: Any, segments: Sequence[Segment], language: str) -> None:
    """What kind of segment there is, and a title over each group that is wide enough."""
    start, end = axes.get_xlim()
    _bars(axes, [(start, end - start)], STRIP, 0.2, UNLABELLED)
    measured = [s for s in segments if s.kind in MEASURED]
    for segment in measured:
        _bars(axes, [(segment.t_start, segment.t_end - segment.t_start)], STRIP, 0.2,
              KINDS[segment.kind])  # fmt: skip
    for title, group in groupby(measured, key=lambda segment: _group_title(segment, language)):
        first, *rest = group
        last = rest[-1] if rest else first
        if (last.t_end - first.t_start) / (end - start) * (RIGHT - LEFT) > text_width(title):
            axes.text((first.t_start + last.t_end) / 2, TITLES, title, color=GREY, ha="center")


def _group_title(segment: Segment, language: str) -> str:
    title = say(message(f"chart-segments.{segment.kind}"), language)
    return title if segment.kind == "static" else f"{title} {segment.axis}"


def _cells(axes: Any, cells: ExcessCells) -> None:
    """Neighbours of one colour are drawn as one."""
    classes = np.where(np.isnan(cells.excess), len(COLOURS) - 1,
                       np.searchsorted(THRESHOLDS, cells.excess, "right"))  # fmt: skip
    for row, of_channel in enumerate(classes):
        first = np.flatnonzero(np.diff(of_channel, prepend=-1))
        starts, ends = cells.edges[first], cells.edges[np.append(first[1:], len(of_channel))]
        colours = [COLOURS[i] for i in of_channel[first]]
        _bars(axes, np.column_stack([starts, ends - starts]), row, CELL, colours)
        axes.hlines([row, row + CELL], *axes.get_xlim(), color="#cccccc", linewidth=0.6)


def _bars(axes: Any, spans: Any, row: float, height: float, colours: Any) -> None:
    axes.broken_barh(spans, (row, height), facecolors=colours, antialiased=False, linewidth=0,
                     clip_on=False)  # fmt: skip


def _findings(
    axes: Any, findings: Sequence[ReportedFinding], cells: ExcessCells, language: str
) -> None:
    """Bars below each row where a finding sits, its share at the right end, its title below."""
    start, end = axes.get_xlim()
    spans = {s.name: (s.t_start, s.t_end - s.t_start) for s in cells.segments}
    least = (end - start) / (RIGHT - LEFT) * 1.5
    marked = dict.fromkeys(CHANNELS, 0)
    for number, finding in enumerate(findings):
        for channel in dict.fromkeys(place.channel for place in finding.where):
            if channel not in marked:  # several at once, with little in each
                continue
            places = [place for place in finding.where if place.channel == channel]
            names = [name for place in places for name in place.segments if name in spans]
            row, before = CHANNELS.index(channel), marked[channel]
            bars = [(t, max(width, least)) for t, width in map(spans.__getitem__, names)]
            _bars(axes, bars or [(start, end - start)], row + CELL + 0.03 + (before % 3) * BAR,
                  BAR - 0.02, FINDINGS[number])  # fmt: skip
            share = percent(sum(place.share for place in places))
            _disc(axes, number, share, RIGHT + 20 + 64 * (before % 2),
                  ROW * (len(CHANNELS) - row - 0.28 - 0.36 * (before // 2)), 11)  # fmt: skip
            marked[channel] += 1
        title = say(capital(finding.title), language)
        words = title if finding.effect == UNNAMED else f"{title} ({finding.effect})"
        _disc(axes, number, words, LEFT + 8, -88 - 24 * number, 13)


def _disc(axes: Any, number: int, words: str, x: float, y: float, size: float) -> None:
    """A finding's number with words at its right: px, x in the picture, y above the axes' foot."""
    at: Any = {"xy": (0, 0), "xycoords": "axes fraction", "textcoords": "offset points",
               "va": "center"}  # fmt: skip
    disc = {"boxstyle": "circle,pad=0.25", "facecolor": FINDINGS[number], "edgecolor": "none"}
    axes.annotate(f"{number + 1}", xytext=(x - LEFT, y), ha="center", color="white",
                  weight="bold", fontsize=11, bbox=disc, **at)  # fmt: skip
    axes.annotate(words, xytext=(x - LEFT + 14, y), fontsize=size, **at)


def _colour_legend(axes: Any, cells: ExcessCells, language: str) -> None:
    from matplotlib.patches import Patch

    present = {segment.kind for segment in cells.segments}
    none, unknown, excess = (
        say(message(id_), language) for id_ in ("chart-none", "chart-not-known", "chart-excess")
    )
    meanings = (none, *(f"> {sigmas:g} σ" for sigmas in THRESHOLDS), unknown)
    handles = [Patch(facecolor=colour, edgecolor="#bbbbbb", linewidth=0.6, label=meaning)
               for colour, meaning in zip(COLOURS, meanings, strict=True)]  # fmt: skip
    handles += [Patch(facecolor=colour, label=say(message(f"chart-kinds.{kind}"), language))
                for kind, colour in KINDS.items() if kind in present]  # fmt: skip
    axes.annotate(excess, (0, 0), xycoords="axes fraction", xytext=(-8, -56),
                  textcoords="offset points", color=GREY, va="center", ha="right")  # fmt: skip
    axes.legend(handles=handles, ncols=len(handles), loc="center left", borderpad=0,
                bbox_to_anchor=(0, -56 / (ROW * len(CHANNELS))), borderaxespad=0, handlelength=1.6,
                columnspacing=1.4, handletextpad=0.5)  # fmt: skip
