"""The verdict in a paragraph: what was tested, what was found, what is left unexplained."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from schemas.discrepancy import HeldOut, ReportedFinding
from schemas.recording import MEASURED, TRIADS
from schemas.text import Statement
from tasks.explain.correction.consequences import OVERALL, moved_by
from tasks.explain.explanation import Explanation
from tasks.explain.report.names import channel_title, parameter_text
from tasks.explain.report.statements import sentences
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.words import Message, Sayable, clauses, message, statement
from tasks.words.quantities import chi2, percent, plain, probability

CLEAR_GAIN = 0.95  # what a residual falls to where it is worth stating


def verdict_statement(explanation: Explanation, findings: Sequence[ReportedFinding]) -> Statement:
    """The answer as one paragraph."""
    left = chi2(explanation.held_out.chi2_per_dof_before)
    if explanation.verdict == "no_mismatch":
        nothing = message("report-nothing-found", chi2=left)
        return statement(sentences([nothing, tested(explanation), detected(explanation)]))
    named = [finding for finding in findings if finding.effect != "unnamed"]
    parts: list[Sayable] = [_left_out(named)] if named else []
    if explanation.verdict != "explained":
        parts.append(_unnamed(explanation.verdict, findings))
    parts += [_gained(explanation.held_out), _moved(findings), detected(explanation)]
    return statement(sentences(parts))


def tested(explanation: Explanation) -> Message:
    """What the recording offered to the test: its length, channels and segments."""
    recording = explanation.recording
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


def detected(explanation: Explanation) -> Message:
    """The p-value of the strongest mismatch against the rate of false alarms."""
    return message(
        "report-detected", p=probability(explanation.p_value), limit=f"{FALSE_ALARMS:g}",
        odds=round(1.0 / FALSE_ALARMS),
    )  # fmt: skip


def _left_out(findings: Sequence[ReportedFinding]) -> Message:
    titles = [
        message("report-left-out-size", title=finding.title,
                size=parameter_text(finding.parameters[0]))
        if len(finding.parameters) == 1 else finding.title
        for finding in findings
    ]  # fmt: skip
    return message("report-left-out", findings=clauses(titles))


def _unnamed(verdict: str, findings: Sequence[ReportedFinding]) -> Message:
    follows = [f.follows for f in findings if f.effect == "unnamed" and f.follows]
    return message(
        "report-unnamed", verdict=verdict, described=len(follows), follows=clauses(follows)
    )


def _gained(held_out: HeldOut) -> Message:
    before, after = chi2(held_out.chi2_per_dof_before), chi2(held_out.chi2_per_dof_after)
    ratios = held_out.rms_ratio
    best = min(ratios, key=lambda channel: ratios[channel], default="")
    if not best or ratios[best] >= CLEAR_GAIN:
        return message("report-gained", before=before, after=after)
    return message(
        "report-gained-most", before=before, after=after, channel=channel_title(best),
        share=percent(ratios[best]),
    )  # fmt: skip


def _moved(findings: Sequence[ReportedFinding]) -> Sayable:
    verdicts = len({change.item for finding in findings for change in finding.verdict_changes
                    if change.item != OVERALL})  # fmt: skip
    values = len({(moved.item, moved.element) for finding in findings
                  for moved in finding.consequences if moved_by(moved) > 1.0})  # fmt: skip
    if verdicts:
        return message("report-values-and-verdicts-moved", values=values, verdicts=verdicts)
    return message("report-values-moved", values=values) if values else ""
