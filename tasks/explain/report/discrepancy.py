"""The published form of the result (`mimu-discrepancy/1`)."""

from collections.abc import Mapping, Sequence

import numpy as np

from schemas.discrepancy import (
    Consequence,
    Detection,
    Discrepancy,
    EvidenceFor,
    ReportedFinding,
    VerdictChange,
    Where,
)
from schemas.text import Remark
from tasks.explain.channels import CHANNELS
from tasks.explain.correction.consequences import Consequences
from tasks.explain.explanation import UNNAMED, Explanation, Finding, Refusal
from tasks.explain.report.names import channel_title
from tasks.explain.report.statements import finding_statement, small_statement
from tasks.explain.report.unnamed import (
    far_beyond,
    pattern_of,
    refused,
    setting_suspected,
    title_of,
    usual_cause,
)
from tasks.explain.report.verdict import verdict_statement
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.model.effect import next_step, separating_recording
from tasks.rendering.chart import picture_file
from tasks.version import code_version
from tasks.words import LANGUAGES, Sayable, message, statement

PICTURES = ("where", "before_after", "shares")
NOT_WRITTEN = statement("")


def discrepancy_of(
    explanation: Explanation, wheres: Sequence[tuple[Where, ...]], effects: Consequences
) -> Discrepancy:
    """The whole discrepancy of an explanation, in every language.

    wheres: one entry for each finding, in the order of the findings, as `effects` has them.
    Raises ValueError where their number differs from that of the findings.
    """
    left_over = {
        channel: float(value)
        for channel, value in zip(CHANNELS, explanation.left_over, strict=True)
        if np.isfinite(value)
    }
    joint = [
        tuple(n + 1 for n in some if n != own)
        for own, some in enumerate(effects.sets or [()] * len(wheres))
    ]
    parts = zip(
        explanation.findings, wheres, effects.of_findings, effects.changes, joint, strict=True
    )
    draft = Discrepancy(
        recording_id=explanation.recording.manifest.recording_id,
        digest=explanation.recording.digest,
        code_version=code_version(),
        model=statement(explanation.model),
        verdict=explanation.verdict,
        detection=Detection(p_value=explanation.p_value, false_alarm_rate=FALSE_ALARMS),
        explained_share=explanation.explained_share,
        left_over=left_over,
        findings=tuple(_published(*each, left_over, effects.together) for each in parts),
        small_remainders=tuple(
            statement(small_statement(title_of(each), each.share)) for each in explanation.small
        ),
        consequences=effects.together,
        verdict_changes=effects.changes_together,
        held_out=explanation.held_out,
        figures=tuple(picture_file(name, language) for language in LANGUAGES for name in PICTURES),
        remarks=tuple(map(statement, explanation.remarks)),
        statement=NOT_WRITTEN,
    )
    seen = [one for one in explanation.remarks if isinstance(one, Remark) and one.run == "invalid"]
    written = verdict_statement(draft, explanation.recording, seen)
    return draft.model_copy(update={"statement": written})


def _published(
    finding: Finding,
    wheres: tuple[Where, ...],
    consequences: tuple[Consequence, ...],
    changes: tuple[VerdictChange, ...],
    jointly_with: tuple[int, ...],
    left_over: Mapping[str, float],
    together: Sequence[Consequence],
) -> ReportedFinding:
    unnamed, setting = finding.effect == UNNAMED, setting_suspected(finding, left_over)
    draft = ReportedFinding(
        effect=finding.effect,
        family=finding.family,
        title=statement(title_of(finding)),
        channels=tuple(CHANNELS[i] for i in finding.channels),
        where=wheres,
        parameters=finding.parameters,
        evidence=EvidenceFor(delta_bic=finding.delta_bic, held_out_gain_nats=finding.held_out_gain),
        share=finding.share,
        homogeneity_p=finding.homogeneity_p,
        group=finding.group or None,
        common=finding.common,
        unlisted_form=finding.unlisted,
        refused=statement(refused(finding.refusal, setting))
        if finding.refusal and unnamed
        else None,
        equation=finding.equation,
        source=finding.source,
        follows=statement(pattern_of(finding)) if unnamed else None,
        indistinguishable_from=finding.indistinguishable,
        separating_recording=statement(finding.separated_by) if finding.separated_by else None,
        consequences=consequences,
        jointly_with=jointly_with,
        verdict_changes=changes,
        next=statement(next_of(finding, wheres, setting)),
        statement=NOT_WRITTEN,
    )
    text = finding_statement(draft, left_over, together)
    return draft.model_copy(update={"statement": text})


def next_of(finding: Finding, places: tuple[Where, ...], setting: bool) -> Sayable:
    """What an engineer does next: checks a setting, the fixture, the logger, or records something.

    places: by falling share. setting: a wrong setting is suspected.
    """
    if finding.effect != UNNAMED:
        return next_step(finding.effect) or finding.separated_by or _by_place(places)
    if finding.refusal is None:
        return _by_place(places)
    return _after_refusal(finding.refusal, setting) or _by_place(places)


ALIKE_FOR_ALL = {
    "overshadowed": "report-next-overshadowed",
    "reference_noise": "report-next-reference-noise",
    "placed": "report-next-placed",
    "one_end": "report-next-one-end",
    "both_ways": "report-next-mode",
    "swings": "report-next-mode",
    "switching": "report-next-switching",
}  # what is next, whatever name was refused


def _after_refusal(refusal: Refusal, setting: bool) -> Sayable | None:
    if refusal.kind == "implausible":
        if setting:
            return message("report-next-implausible", usual=usual_cause(refusal))
        return message("report-next-alike") if far_beyond(refusal) else None
    if refusal.kind == "inhomogeneous":
        return message("report-next-inhomogeneous", parts=refusal.parts or "time")
    if refusal.kind == "channel_worse" and refusal.channel is not None:
        return message("report-next-channel", channel=channel_title(CHANNELS[refusal.channel]))
    if refusal.kind in ALIKE_FOR_ALL:
        return message(ALIKE_FOR_ALL[refusal.kind])
    recording = separating_recording(refusal.name)
    return message("report-next-undetermined", recording=recording) if recording else None


def _by_place(places: tuple[Where, ...]) -> Sayable:
    return message("report-next", dimension=places[0].dimension if places else "level")
