"""The answer as it is published (`mimu-discrepancy/1`)."""

from collections.abc import Sequence

from schemas.discrepancy import (
    Consequence,
    Detection,
    Discrepancy,
    EvidenceFor,
    ReportedFinding,
    VerdictChange,
    Where,
)
from schemas.text import Statement
from tasks.explain.channels import CHANNELS
from tasks.explain.explanation import Explanation, Finding
from tasks.explain.report.statements import finding_statement
from tasks.explain.report.verdict import verdict_statement
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.version import code_version
from tasks.words import statement

FIGURES = ("where.svg", "before_after.svg")


def discrepancy_of(
    explanation: Explanation,
    wheres: Sequence[tuple[Where, ...]],
    consequences: Sequence[tuple[Consequence, ...]],
    changes: Sequence[tuple[VerdictChange, ...]],
) -> Discrepancy:
    """The whole answer of an explanation, in every language.

    wheres, consequences, changes: one entry for each finding, in the order of the findings.
    Raises ValueError where their number differs from that of the findings.
    """
    findings = tuple(
        _published(*parts)
        for parts in zip(explanation.findings, wheres, consequences, changes, strict=True)
    )
    return Discrepancy(
        recording_id=explanation.recording.manifest.recording_id,
        digest=explanation.recording.digest,
        code_version=code_version(),
        model=statement(explanation.model),
        verdict=explanation.verdict,
        detection=Detection(p_value=explanation.p_value, false_alarm_rate=FALSE_ALARMS),
        findings=findings,
        held_out=explanation.held_out,
        figures=FIGURES,
        remarks=tuple(map(statement, explanation.remarks)),
        statement=verdict_statement(explanation, findings),
    )


def _published(
    finding: Finding,
    wheres: tuple[Where, ...],
    consequences: tuple[Consequence, ...],
    changes: tuple[VerdictChange, ...],
) -> ReportedFinding:
    draft = ReportedFinding(
        effect=finding.effect,
        family=finding.family,
        title=statement(finding.title),
        channels=tuple(CHANNELS[i] for i in finding.channels),
        where=wheres,
        parameters=finding.parameters,
        evidence=EvidenceFor(delta_bic=finding.delta_bic, held_out_gain_nats=finding.held_out_gain),
        equation=finding.equation,
        source=finding.source,
        follows=statement(finding.follows) if finding.follows else None,
        indistinguishable_from=finding.indistinguishable,
        separating_recording=statement(finding.separated_by) if finding.separated_by else None,
        consequences=consequences,
        verdict_changes=changes,
        statement=Statement(en="", zh=""),
    )
    return draft.model_copy(update={"statement": finding_statement(draft)})
