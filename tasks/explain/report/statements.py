"""What an engineer would write about each finding, and the whole answer as it is published."""

from collections.abc import Sequence

from schemas.discrepancy import (
    Consequence,
    Detection,
    Discrepancy,
    EvidenceFor,
    FindingSaid,
    FoundParameter,
    Statement,
    VerdictChange,
    Where,
)
from tasks.certificate.names import VERDICTS
from tasks.explain.correction.consequences import moved_by
from tasks.explain.explanation import CHANNELS, Explanation, Finding
from tasks.explain.report.verdicts import verdict_statement
from tasks.explain.report.words import (
    bic_words,
    channel_name,
    effect_name,
    element_name,
    in_expanded,
    joined,
    parameter_text,
    percent,
    plain,
    quantity,
    sentence,
    text_of,
    times_more_probable,
)
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.model.term import Text
from tasks.version import code_version
from tasks.words import statement

PICTURES = ("where.svg", "before_after.svg")
MOST_PARAMETERS, MOST_WHERES = 3, 2  # in a sentence; tables hold all of them


def said(
    explanation: Explanation,
    wheres: Sequence[tuple[Where, ...]],
    consequences: Sequence[tuple[Consequence, ...]],
    changes: Sequence[tuple[VerdictChange, ...]],
) -> Discrepancy:
    """The whole answer (`mimu-discrepancy/1`) of an explanation, in both languages.

    wheres, consequences, changes: one entry for each finding, in the order of the findings.
    Raises ValueError where their number differs from that of the findings.
    """
    findings = tuple(
        _finding_said(*each)
        for each in zip(explanation.findings, wheres, consequences, changes, strict=True)
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
        figures=PICTURES,
        remarks=tuple(statement(remark) for remark in explanation.remarks),
        statement=_statement(verdict_statement(explanation, findings)),
    )


def what(finding: FindingSaid) -> Text:
    """What it is and how large, U with k = 2; for what has no name, what it follows."""
    told = sorted(finding.parameters, key=_significance, reverse=True)[:MOST_PARAMETERS]
    sizes = ", ".join(parameter_text(parameter) for parameter in told)
    more = len(finding.parameters) - len(told)
    en, zh = text_of(finding.title)
    if sizes:
        en, zh = f"{en}: {sizes}", f"{zh}：{sizes}"
        en += f", and {more} more (k = 2)" if more else " (k = 2)"
        zh += f" 等 {len(finding.parameters)} 个参数（k = 2）" if more else "（k = 2）"
    parts = [sentence((en, zh))]
    if finding.follows not in (None, finding.title):
        assert finding.follows is not None
        follows = text_of(finding.follows)
        parts.append(sentence((f"What it follows: {follows[0]}", f"其变化规律：{follows[1]}")))
    return joined(parts, " ", "")


def where(finding: FindingSaid) -> Text:
    """The channels and circumstances that hold most of it; empty where nothing was located."""
    entries = sorted(finding.where, key=lambda each: each.share, reverse=True)[:MOST_WHERES]
    if not entries:
        return ("", "")
    parts = []
    for each in entries:
        en, zh = channel_name(each.channel)
        share = percent(each.share)
        parts.append(
            (f"{en} ({share}): {each.description.en}", f"{zh}（{share}）：{each.description.zh}")
        )
    en, zh = joined(parts)
    return sentence((f"It sits in {en}", f"所在：{zh}"))


def why(evidence: EvidenceFor) -> Text:
    """Why it is believed: what it gains on data the fit did not see, and ΔBIC in plain words."""
    gain, bic = evidence.held_out_gain_nats, evidence.delta_bic
    nats, times = plain(gain), times_more_probable(gain)
    words = bic_words(bic)
    if gain > 0:
        en = f"stretches that the fit did not see become {times[0]} as probable ({nats} nats)"
        zh = f"未参与拟合的区段，其数据概率提高到 {times[1]}（{nats} nat）"
    else:
        en = f"stretches that the fit did not see are not predicted better ({nats} nats)"
        zh = f"未参与拟合的区段预测未见改善（{nats} nat）"
    return sentence(
        (
            f"{en}; ΔBIC = {plain(bic)}: {words[0]}, with its parameters paid for",
            f"{zh}；ΔBIC = {plain(bic)}：{words[1]}（已计入参数个数）",
        )
    )


def alternatives(finding: FindingSaid) -> Text:
    """What else would fit this recording as well; empty where nothing would."""
    if not finding.indistinguishable_from:
        return ("", "")
    names = [effect_name(each) for each in finding.indistinguishable_from]
    en, zh = joined(names, " or ", "或")
    return sentence(
        (
            f"this recording cannot tell it from {en}",
            f"仅凭本次记录无法与以下效应区分：{zh}",
        )
    )


def to_record(finding: FindingSaid) -> Text:
    """What to record to be sure; empty where nothing is needed."""
    if finding.separating_recording is None:
        return ("", "")
    en, zh = text_of(finding.separating_recording)
    return sentence((f"To be sure, record: {en}", f"如需确认，应补充记录：{zh}"))


def on_certificate(finding: FindingSaid) -> Text:
    """The largest of its consequences in U, and the verdicts it changes; empty without any."""
    parts = []
    largest = max(finding.consequences, key=moved_by, default=None)
    if largest is not None and moved_by(largest) > 0.0:
        parts.append(_consequence(largest))
    for change in finding.verdict_changes:
        en, zh = element_name(change.item, "")
        before, after = (VERDICTS.get(v, (v, v)) for v in (change.before, change.after))
        parts.append(
            sentence(
                (
                    f"the verdict on {en[:1].lower()}{en[1:]} changes from {before[1]} to "
                    f"{after[1]}",
                    f"{zh}的结论由“{before[0]}”变为“{after[0]}”",
                )
            )
        )
    return joined(parts, " ", "")


def _consequence(each: Consequence) -> Text:
    en, zh = element_name(each.item, each.element)
    assert each.before is not None
    assert each.after is not None
    assert each.U is not None
    like = max(abs(each.before), abs(each.after))
    before, after = (quantity(v, each.U, each.unit, like) for v in (each.before, each.after))
    times = in_expanded(each.after - each.before, each.U)
    return sentence(
        (
            f"of the certificate it moves most: {en}, from {before} with it left out to "
            f"{after} with it taken into account (k = 2), {times} U",
            f"对证书影响最大的是：{zh}，未计入时为 {before}，计入后为 {after}（k = 2），"
            f"变化 {times} U",
        )
    )


def _significance(parameter: FoundParameter) -> float:
    return abs(parameter.value) / parameter.u if parameter.u > 0 else float("inf")


def _finding_said(
    finding: Finding,
    wheres: tuple[Where, ...],
    consequences: tuple[Consequence, ...],
    changes: tuple[VerdictChange, ...],
) -> FindingSaid:
    silent = FindingSaid(
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
    parts = (
        what(silent), where(silent), why(silent.evidence), alternatives(silent),
        to_record(silent), on_certificate(silent),
    )  # fmt: skip
    whole = joined([part for part in parts if part[0]], " ", "")
    return silent.model_copy(update={"statement": _statement(whole)})


def _statement(text: Text) -> Statement:
    return Statement(en=text[0], zh=text[1])
