"""The verdict in one paragraph: how much is explained, what was found, and what remains."""

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from schemas.discrepancy import Detection, Discrepancy, HeldOut, ReportedFinding
from schemas.recording import MEASURED, TRIADS, Recording
from schemas.text import Remark, Statement
from tasks.explain.correction.consequences import OVERALL, moved_by
from tasks.explain.evidence.findings import MOSTLY_NOISE
from tasks.explain.explanation import CHANNELS, UNNAMED
from tasks.explain.report.statements import (
    LEAST,
    before_and_after,
    capital,
    channel_title,
    either,
    element_title,
    lower,
    parameter_text,
    rivals,
    sentences,
    shift_text,
    short_channel_title,
)
from tasks.model.term import LOGGER
from tasks.rendering import AFTER, BEFORE, FINDINGS, GREY, LETTER, draw, text_width
from tasks.words import Message, Sayable, clauses, message, say, statement
from tasks.words.numbers import chi2, percent, plain, probability

if TYPE_CHECKING:
    from matplotlib.figure import Figure


CLEAR_GAIN = 0.95  # what a residual falls to where it is worth stating


def verdict_statement(
    discrepancy: Discrepancy, recording: Recording, invalid: Sequence[Remark] = ()
) -> Statement:
    """A discrepancy as one paragraph; its first sentence says how much of it is explained, after
    what was found on sight that makes the run invalid.

    discrepancy: all but this statement. recording: what it is of.
    """
    first: list[Sayable] = [message("report-invalid"), *invalid] if invalid else []
    if discrepancy.verdict == "no_mismatch":
        left = chi2(discrepancy.held_out.chi2_per_dof_before)
        nothing = message("report-nothing-found", chi2=left)
        return statement(
            sentences([*first, nothing, tested(recording), detected(discrepancy.detection)])
        )
    named = [finding for finding in discrepancy.findings if finding.effect != UNNAMED]
    parts = [
        *first,
        _summary(discrepancy) if discrepancy.findings or discrepancy.left_over else "",
        _left_out(named) if named else "",
        "" if discrepancy.verdict == "explained" else _unnamed(discrepancy),
        _left_over(discrepancy), small_remainders(discrepancy), _gained(discrepancy.held_out),
        _moved(discrepancy), detected(discrepancy.detection),
    ]  # fmt: skip
    return statement(sentences(parts))


def _summary(discrepancy: Discrepancy) -> Message:
    """How much of the mismatch is explained, how much is not, and what to look at first."""
    explained = min(max(discrepancy.explained_share, 0.0), 1.0)
    named = [finding.share for finding in discrepancy.findings if finding.effect != UNNAMED]
    by_name = min(sum(named), explained)
    return message(
        "report-summary", all=percent(explained), named=percent(by_name),
        unnamed=percent(explained - by_name), left=percent(1.0 - explained),
        kinds=_kinds(discrepancy, len(named)),
        first=_first(discrepancy, 1.0 - explained),
    )  # fmt: skip


def _kinds(discrepancy: Discrepancy, named: int) -> str:
    """Whether all, some or none of the findings have names, or the residual shows none of them."""
    quiet = all(value < MOSTLY_NOISE for value in discrepancy.left_over.values())
    if named and quiet and all(finding.share < LEAST for finding in discrepancy.findings):
        return "absorbed"
    if named == len(discrepancy.findings):
        return "all"
    return "some" if named else "none"


def _first(discrepancy: Discrepancy, left: float) -> Sayable:
    """What to look at first: a fault of the logger, or the largest finding, or the residual if that
    is larger.
    """
    if discrepancy.findings and discrepancy.findings[0].family == LOGGER:
        return discrepancy.findings[0].title
    largest = max(discrepancy.findings, key=lambda finding: finding.share, default=None)
    channels = discrepancy.left_over
    if largest is not None and (largest.share >= left or not channels):
        return largest.follows or largest.title
    channel = max(channels, key=lambda each: channels[each])
    left_in = channel_title(channel)
    return message("report-first-left", channel=left_in, chi2=chi2(channels[channel]))


def _left_over(discrepancy: Discrepancy) -> Sayable:
    """The channels whose residual exceeds noise, with its size; empty if none does."""
    high = tuple(
        message("report-left-in", channel=channel_title(channel), chi2=chi2(value))
        for channel, value in sorted(discrepancy.left_over.items(), key=lambda item: -item[1])
        if value >= MOSTLY_NOISE
    )
    return message("report-left", channels=high) if high else ""


def small_remainders(discrepancy: Discrepancy) -> Sayable:
    """What removes little of the mismatch, in one line; empty where nothing does."""
    small = discrepancy.small_remainders
    return message("report-small", remainders=clauses(small)) if small else ""


def tested(recording: Recording) -> Message:
    """What the recording offered to the test: its length, channels and segments."""
    t = recording.imu.t
    minutes = plain((t[-1] - t[0]) / 60.0) if len(t) > 1 else "0"
    rate = plain(1.0 / float(np.median(np.diff(t)))) if len(t) > 1 else "0"
    channels = sum(name in recording.imu.columns for triad in TRIADS for name in triad)
    counts = Counter(segment.kind for segment in recording.manifest.segments or ())
    segments = tuple(message(f"report-{kind}-segments", count=counts[kind])
                     for kind in MEASURED if counts[kind])  # fmt: skip
    return message(
        "report-tested", channels=channels, minutes=minutes, rate=rate, kinds=len(segments),
        segments=segments,
    )  # fmt: skip


def detected(detection: Detection) -> Message:
    """The p-value of the strongest mismatch against the rate of false alarms."""
    rate = detection.false_alarm_rate
    return message(
        "report-detected", p=probability(detection.p_value), limit=f"{rate:g}",
        odds=round(1.0 / rate),
    )  # fmt: skip


def _left_out(findings: Sequence[ReportedFinding]) -> Message:
    return message("report-left-out", findings=clauses([*map(_with_rivals, findings)]))


def _with_rivals(finding: ReportedFinding) -> Sayable:
    """The name of a finding, with its size if that is one, and what it cannot be told from."""
    title: Sayable = finding.title
    if len(finding.parameters) == 1:
        size = parameter_text(finding.parameters[0])
        title = message("report-left-out-size", title=title, size=size)
    others = rivals(finding)
    return message("report-left-out-or", title=title, others=either(others)) if others else title


def _unnamed(discrepancy: Discrepancy) -> Message:
    follows = [finding.follows for finding in discrepancy.findings if finding.follows]
    return message(
        "report-unnamed",
        verdict=discrepancy.verdict,
        described=len(follows),
        follows=clauses(follows),
    )


def _gained(held_out: HeldOut) -> Message:
    pair = held_out.chi2_per_dof_before, held_out.chi2_per_dof_after
    before, after = map(chi2, pair)
    ratios = held_out.rms_ratio
    best = min(ratios, key=lambda channel: ratios[channel], default="")
    most = bool(best) and ratios[best] < CLEAR_GAIN
    return message(
        "report-gained", before=before, after=after,
        change="level" if before == after else "rises" if pair[1] > pair[0] else "falls",
        most=int(most), channel=channel_title(best) if most else "",
        share=percent(ratios[best]) if most else "",
    )  # fmt: skip


def _moved(discrepancy: Discrepancy) -> Sayable:
    """What all findings together do to the certificate, for some take back what others move."""
    verdicts = sum(change.item != OVERALL for change in discrepancy.verdict_changes)
    values = sum(moved_by(moved) > 1.0 for moved in discrepancy.consequences)
    most = max(discrepancy.consequences, key=moved_by, default=None)
    if most is None or not values + verdicts:
        return ""
    made = before_and_after(most)
    return message(
        "report-moved", findings=len(discrepancy.findings), values=values, verdicts=verdicts,
        element=lower(element_title(most.item, most.element)), before=made.text(0),
        after=made.text(1), times=shift_text(most),
    )  # fmt: skip


# shares.svg: the share of the mismatch that each finding removes, and the rest by channel.

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
