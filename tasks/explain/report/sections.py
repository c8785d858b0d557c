"""The page's sections: the cards of the findings, the tables, the method."""

from html import escape

from schemas.discrepancy import Consequence, Discrepancy, FindingSaid, HeldOut, VerdictChange
from tasks.certificate.names import VERDICTS
from tasks.explain.correction.consequences import moved_by
from tasks.explain.explanation import Explanation
from tasks.explain.report.look import both, table
from tasks.explain.report.statements import alternatives, on_certificate, why
from tasks.explain.report.svg import FINDINGS
from tasks.explain.report.verdicts import detected, tested
from tasks.explain.report.words import (
    capital,
    channel_name,
    chi2,
    element_name,
    in_expanded,
    numbers,
    percent,
    power_of_ten,
    printed_unit,
    sensible,
    sentence,
    text_of,
)
from tasks.model.term import Text
from tasks.version import code_version
from tasks.words import statement
from tasks.words.rounding import USUAL_K, column

DIMENSIONS: dict[str, Text] = {
    "rate": ("rate", "角速率"),
    "attitude": ("attitude", "姿态"),
    "rotation_phase": ("phase of the turn", "转动相位"),
    "frequency": ("frequency", "频率"),
    "temperature": ("temperature", "温度"),
    "time": ("time", "时间"),
    "after_moves": ("after moves", "运动之后"),
    "ramps": ("ramps", "加减速段"),
    "recorded": ("a recorded quantity", "已记录的环境量"),
    "level": ("everywhere alike", "各处相同"),
}
NOTHING_ELSE: Text = (
    "No other effect of the catalogue fits this recording as well.",
    "目录中没有其他效应能同样好地解释本次记录。",
)
MOST_SEGMENTS = 4


def colour_of(number: int) -> str:
    """The colour of a finding in the picture and on its card; grey beyond those marked."""
    return FINDINGS[number] if number < len(FINDINGS) else "#888888"


def card(number: int, finding: FindingSaid) -> str:
    """One finding: what, how much, where, why, what else, what to record, the certificate."""
    colour = colour_of(number)
    rows = [
        (("How large", "参数"), _parameters(finding)),
        (
            ("What it follows", "变化规律"),
            _told(sentence(text_of(finding.follows)))
            if finding.follows not in (None, finding.title)
            else "",
        ),
        (("Equation", "公式"), _equation(finding)),
        (("Where", "所在"), _wheres(finding)),
        (("Why we believe it", "依据"), both(why(finding.evidence))),
        (("Could also be", "其他可能"), _other(finding)),
        (
            ("To be sure, record", "如需确认，补充记录"),
            _told(sentence(text_of(finding.separating_recording)))
            if finding.separating_recording
            else "",
        ),
        (("On the certificate", "对证书的影响"), _told(on_certificate(finding))),
    ]
    entries = "".join(f"<dt>{both(head)}</dt><dd>{body}</dd>" for head, body in rows if body)
    return (
        f'<section class="card" style="border-left-color:{colour}">'
        f'<h3><span class="disc" style="background:{colour}">{number + 1}</span>'
        f"{both(capital(text_of(finding.title)))} <code>{escape(finding.effect)}</code></h3>"
        f"<dl>{entries}</dl></section>"
    )


def _told(text: Text) -> str:
    return both(text) if text[0] else ""


def _parameters(finding: FindingSaid) -> str:
    rows = []
    for each in finding.parameters:
        value, U, power, unit = numbers(each.value, USUAL_K * each.u, each.unit)
        rows.append([escape(each.name), value, U or "–",
                     escape(f"{power} {printed_unit(unit)}".strip())])  # fmt: skip
    head = [("parameter", "参数"), ("value", "值"), ("U (k = 2)", "U（k = 2）"), ("unit", "单位")]
    return table([both(each) for each in head], rows, (1, 2)) if rows else ""


def _equation(finding: FindingSaid) -> str:
    source = f' <span class="quiet">{escape(finding.source)}</span>' if finding.source else ""
    told = f'<span class="equation">{escape(finding.equation)}</span>{source}'
    return told if finding.equation or source else ""


def _wheres(finding: FindingSaid) -> str:
    rows = []
    for each in sorted(finding.where, key=lambda one: one.share, reverse=True):
        names = ", ".join(each.segments[:MOST_SEGMENTS])
        more = len(each.segments) - MOST_SEGMENTS
        names += f" (+ {more})" if more > 0 else ""
        rows.append([both(channel_name(each.channel)), percent(each.share),
                     both(text_of(each.description)), both(DIMENSIONS[each.dimension]),
                     f'<span class="quiet">{escape(names)}</span>'])  # fmt: skip
    head = [("channel", "通道"), ("share", "占比"), ("where", "位置"), ("along", "维度"),
            ("segments", "区段")]  # fmt: skip
    return table([both(each) for each in head], rows, (1,)) if rows else ""


def _other(finding: FindingSaid) -> str:
    names = ", ".join(f"<code>{escape(name)}</code>" for name in finding.indistinguishable_from)
    if names:
        return f"{both(alternatives(finding))} ({names})"
    return "" if finding.effect == "unnamed" else both(NOTHING_ELSE)


def held_out(gains: HeldOut) -> str:
    """What is left on stretches that the fit did not see, and by how much each channel gains."""
    names = [both(channel_name(channel)) for channel in gains.rms_ratio]
    ratios = [percent(ratio) for ratio in gains.rms_ratio.values()]
    head = both(("rms residual, after / before", "残差均方根：后 / 前"))
    left = (chi2(gains.chi2_per_dof_before), chi2(gains.chi2_per_dof_after))
    lead = both(
        (
            "Stretches that the fit did not see: χ² per degree of freedom "
            f"{left[0]} before, {left[1]} after (noise alone: 1).",
            f"未参与拟合的区段：每自由度 χ² 前 {left[0]}，后 {left[1]}（仅有噪声时为 1）。",
        )
    )
    return f"<p>{lead}</p>" + (
        table(["", *names], [[head, *ratios]], tuple(range(1, 7))) if names else ""
    )


def consequences(discrepancy: Discrepancy) -> str:
    """Each value of the certificate before and after, and verdicts that change."""
    rows = [
        _consequence(number, each, finding.verdict_changes)
        for number, finding in enumerate(discrepancy.findings)
        for each in finding.consequences
    ]
    named = {(n, c.item) for n, f in enumerate(discrepancy.findings) for c in f.consequences}
    rows += [
        [str(n + 1), both(element_name(c.item, "")), "–", "–", "–", "", "–", _changed(c)]
        for n, finding in enumerate(discrepancy.findings)
        for c in finding.verdict_changes
        if (n, c.item) not in named
    ]
    if not rows:
        return "<p>" + both(("No value of the certificate was found to be moved.",
                             "未发现证书中有值受其影响。")) + "</p>"  # fmt: skip
    head = [("no.", "序号"), ("value of the certificate", "证书中的值"), ("left out", "未计入"),
            ("taken into account", "计入后"), ("U (k = 2)", "U（k = 2）"), ("unit", "单位"),
            ("change / U", "变化 / U"), ("verdict", "结论")]  # fmt: skip
    return table([both(each) for each in head], rows, (2, 3, 4, 6))


def _consequence(number: int, each: Consequence, changes: tuple[VerdictChange, ...]) -> list[str]:
    values = (each.before, each.after)
    U = each.U or 0.0
    scale = sensible(max(abs(value) for value in (*values, U) if value is not None), each.unit)
    by = scale.factor / 10.0**scale.exponent
    made = column([None if v is None else v * by for v in values], [U * by or None] * 2, USUAL_K)
    change = "–"
    if moved_by(each):
        assert each.before is not None
        assert each.after is not None
        change = in_expanded(each.after - each.before, U)
    power = power_of_ten(scale.exponent + made.exponent)
    unit = f"{power} {printed_unit(scale.unit)}".strip()
    verdict = next((_changed(c) for c in changes if c.item == each.item), "")
    return [str(number + 1), f"{both(element_name(each.item, each.element))} "
            f'<span class="quiet">{escape(each.item)}.{escape(each.element)}</span>',
            made.values[0] or "–", made.values[1] or "–", made.uncertainties[0] or "–",
            escape(unit), change, verdict]  # fmt: skip


def _changed(change: VerdictChange) -> str:
    before, after = (VERDICTS.get(v, (v, v)) for v in (change.before, change.after))
    return f"<b>{both((f'{before[1]} → {after[1]}', f'{before[0]} → {after[0]}'))}</b>"


def method(explanation: Explanation) -> str:
    """What was compared with what, how sure a mismatch is, and how often that is wrong."""
    compared = (
        "The readings are compared with models (1) and (2) of JJF 2003-2022, driven by the motion "
        "that the table reports and by the gravity that the recording tells: no Earth rotation, "
        "no lever arm, a perfect vertical, no temperature, no delay. Every effect of the "
        "catalogue is added in turn and all parameters are fitted again together; what is "
        "added must predict stretches that its fit did not see.",
        "以转台给出的运动和记录给出的重力驱动 JJF 2003—2022 模型(1)、(2)，"
        "与读数比较：不含地球自转、杆臂、基座倾斜、温度及延迟。逐一加入目录中的效应并重新联合拟合全部参数；"
        "加入的效应须能预测未参与其拟合的区段。",
    )
    parts = (compared, tested(explanation), detected(explanation))
    return "".join(f"<p>{both(part)}</p>" for part in parts)


def origins(explanation: Explanation) -> str:
    """Which recording and which code this comes from."""
    manifest = explanation.recording.manifest
    unit = manifest.unit
    rows = [
        [both(("recording", "记录")), f"<code>{escape(manifest.recording_id)}</code>"],
        [both(("digest of its content (SHA-256)", "内容摘要（SHA-256）")),
         f"<code>{escape(explanation.recording.digest) or '–'}</code>"],
        [both(("compared with", "比较对象")), both(text_of(statement(explanation.model)))],
        [both(("unit", "被校单元")),
         escape(" ".join((unit.manufacturer, unit.model, unit.serial)))],
        [both(("station", "校准台位")), escape(manifest.station.id)],
        [both(("made with", "程序版本")), f"<code>mimucal {escape(code_version())}</code>"],
        [both(("as data", "数据")), "<code>report.json</code>, <code>prediction.parquet</code>"],
    ]  # fmt: skip
    return table([], rows)
