"""The verdict in a headline and in a paragraph: what was tested, found, or left unexplained."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from schemas.discrepancy import FindingSaid, HeldOut
from schemas.recording import TRIADS, Kind
from tasks.explain.correction.consequences import OVERALL, moved_by
from tasks.explain.explanation import Explanation
from tasks.explain.report.words import (
    channel_name,
    chi2,
    joined,
    parameter_text,
    percent,
    plain,
    probability,
    sentence,
    text_of,
)
from tasks.explain.search.stepwise import FALSE_ALARMS
from tasks.model.term import Text

CLEARLY = 0.95  # what a residual falls to where it is worth telling

HEADLINES: dict[str, Text] = {
    "no_mismatch": (
        "No mismatch: the standard's model accounts for this recording",
        "未见失配：规范模型足以说明本次记录",
    ),
    "explained": (
        "Explained: what the standard's model leaves out is found",
        "已查明：找到了规范模型所遗漏的物理因素",
    ),
    "partly_explained": (
        "Partly explained: something is found, something stays without a name",
        "部分查明：找到了部分遗漏因素，其余尚无名称",
    ),
    "unexplained": (
        "Unexplained: model and recording differ, and nothing in the catalogue accounts for it",
        "未查明：模型与记录不符，目录中无任何效应可以解释",
    ),
}
KINDS: dict[Kind, tuple[str, str, str]] = {  # one, several, Chinese
    "static": ("rest", "rests", "静止段"),
    "rate": ("constant rate", "constant rates", "恒定角速率段"),
    "rotation": ("turn by a known angle", "turns by a known angle", "定角转动段"),
}


def verdict_statement(explanation: Explanation, findings: Sequence[FindingSaid]) -> Text:
    """The answer as one paragraph, English and Chinese."""
    if explanation.verdict == "no_mismatch":
        return joined([_nothing(explanation), tested(explanation), detected(explanation)], " ", "")
    named = [each for each in findings if each.effect != "unnamed"]
    unnamed = [each for each in findings if each.effect == "unnamed"]
    parts = [_named(named)] if named else []
    parts += [_unnamed(explanation, unnamed)] if explanation.verdict != "explained" else []
    parts += [_gained(explanation.held_out), _consequences(findings), detected(explanation)]
    return joined([part for part in parts if part[0]], " ", "")


def tested(explanation: Explanation) -> Text:
    """What the recording offered to the test: its length, channels and stretches."""
    recording = explanation.recording
    t = recording.imu.t
    minutes = plain((t[-1] - t[0]) / 60.0) if len(t) > 1 else "0"
    rate = plain(1.0 / float(np.median(np.diff(t)))) if len(t) > 1 else "0"
    channels = sum(name in recording.imu.columns for triad in TRIADS for name in triad)
    counts = Counter(s.kind for s in recording.manifest.segments or ())
    kinds = [(f"{counts[k]} {one if counts[k] == 1 else several}", f"{counts[k]} 个{zh}")
             for k, (one, several, zh) in KINDS.items() if counts[k]]  # fmt: skip
    en, zh = joined(kinds, ", ", "、")
    return sentence(
        (
            f"tested were {channels} channels over {minutes} min at {rate} Hz"
            + (f" with {en}" if kinds else ""),
            f"检验了 {channels} 个通道、{minutes} min、{rate} Hz 的数据"
            + (f"，含{zh}" if kinds else ""),
        )
    )


def detected(explanation: Explanation) -> Text:
    """The p-value of the strongest mismatch against the rate of false alarms."""
    p, odds = probability(explanation.p_value), round(1.0 / FALSE_ALARMS)
    return sentence(
        (
            f"the strongest departure from the standard's model has {p}, corrected for how many "
            f"were looked for; a mismatch is stated below p = {FALSE_ALARMS:g}, which "
            f"one clean recording in {odds} reaches by chance",
            f"与规范模型的最强偏离为 {p}（已按检验次数修正）；p < {FALSE_ALARMS:g} 时判为"
            f"失配，无失配的记录约每 {odds} 次有 1 次误报",
        )
    )


def _nothing(explanation: Explanation) -> Text:
    left = chi2(explanation.held_out.chi2_per_dof_before)
    return (
        "Nothing was found that the standard's model leaves out. "
        f"On stretches that the fit did not see it leaves χ² = {left} per degree of freedom "
        "(noise alone: 1). What is smaller than the noise lets see, or what the standard's "
        "parameters absorb whole, this recording cannot show.",
        "未发现规范模型遗漏的物理因素。"
        f"在未参与拟合的区段上，每自由度 χ² = {left}（仅有噪声时为 1）。"
        "小于噪声可分辨程度的效应，或被规范参数完全吸收的效应，本次记录无法显示。",
    )


def _named(findings: Sequence[FindingSaid]) -> Text:
    told = []
    for finding in findings:
        en, zh = text_of(finding.title)
        size = parameter_text(finding.parameters[0]) if len(finding.parameters) == 1 else ""
        told.append((f"{en} ({size})" if size else en, f"{zh}（{size}）" if size else zh))
    en, zh = joined(told, "; ", "；")
    return sentence(
        (
            f"the standard's model leaves out: {en}",
            f"规范模型遗漏了：{zh}",
        )
    )


def _unnamed(explanation: Explanation, findings: Sequence[FindingSaid]) -> Text:
    follows = [text_of(each.follows) for each in findings if each.follows is not None]
    en, zh = joined([(a.rstrip("."), b.rstrip("。")) for a, b in follows])
    rest = explanation.verdict == "partly_explained"
    start = (
        ("a part of the excess", "其余部分失配") if rest else ("what model and recording differ by",
         "模型与记录的差异")
    )  # fmt: skip
    return sentence(
        (
            f"{start[0]} is explained by nothing in the catalogue, and is given no name"
            + (f"; what it follows: {en}" if en else ""),
            f"{start[1]}无法用目录中任何效应解释，故不予命名"
            + (f"；其变化规律：{zh}" if zh else ""),
        )
    )


def _gained(held_out: HeldOut) -> Text:
    before, after = chi2(held_out.chi2_per_dof_before), chi2(held_out.chi2_per_dof_after)
    best = min(held_out.rms_ratio.items(), key=lambda each: each[1], default=None)
    en = zh = ""
    if best is not None and best[1] < CLEARLY:
        name, fallen = channel_name(best[0]), percent(best[1])
        en = f", and the rms residual of the {name[0]} falls to {fallen}"
        zh = f"，{name[1]} 残差均方根降至 {fallen}"
    return sentence(
        (
            f"on stretches that the fit did not see, χ² per degree of freedom goes from "
            f"{before} to {after} (noise alone: 1){en}",
            f"在未参与拟合的区段上，每自由度 χ² 由 {before} 变为 {after}（仅有噪声时为 1）{zh}",
        )
    )


def _consequences(findings: Sequence[FindingSaid]) -> Text:
    changes = {change.item for finding in findings for change in finding.verdict_changes
               if change.item != OVERALL}  # fmt: skip
    moved = {(c.item, c.element) for f in findings for c in f.consequences
             if moved_by(c) > 1.0}  # fmt: skip
    if not changes and not moved:
        return ("", "")
    values = _count(len(moved), "value")
    en = f"taking it into account moves {values} of the certificate by more than U"
    zh = f"计入后，证书中有 {len(moved)} 个值的变化超过 U"
    if changes:
        en += f" and changes {_count(len(changes), 'verdict')}"
        zh += f"，{len(changes)} 项结论改变"
    return sentence((en, zh))


def _count(number: int, noun: str) -> str:
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"
