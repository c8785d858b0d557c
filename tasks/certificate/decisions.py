"""The statement of conformity: limits, decision rules, risks of a wrong decision, verdict."""

import math

from schemas.tolerance import Decision, LimitDecision
from tasks.certificate import cover
from tasks.certificate.fields import Field, given, listed
from tasks.certificate.limits import plain, probability_text
from tasks.certificate.names import RULES, Pair, item_name, symbol
from tasks.certificate.reasons import conditional
from tasks.certificate.typography import pair
from tasks.words.rounding import text
from tasks.words.units import quantity_text

MARKS = (
    "“—”：未规定允许限；“未得”：未能得到该值，原因见表下",
    "—: no limit is laid down; not determined: no value, the reason stands under the table",
)
CHANCES = (
    "判定栏中的百分数为合格概率 P_c",
    "the percentage under a verdict is the probability of conformity P_c",
)
NEAR = (
    "“有条件”：值距允许限小于 U，或超出允许限而按规则接受（ILAC-G8:09/2019）",
    "conditional: the value lies within U of a limit, or is accepted outside it (ILAC-G8:09/2019)",
)
SPECIFIC = (
    "由测得值、标准不确定度 u（正态分布；自由度有限时为 t 分布）计算，未用先验信息"
    "（JCGM 106，9.3）：",
    "from the measured value and its standard uncertainty u (normal, or t where its degrees of "
    "freedom are finite), without prior knowledge (JCGM 106, 9.3): ",
)
ACCEPTING = ("合格判定的错误接受概率 1 − P_c，最大者 {} ({})",
             "false acceptance of a pass, 1 − P_c, the largest {} ({})")  # fmt: skip
REJECTING = ("不合格判定的错误拒绝概率 P_c，最大者 {} ({})",
             "false rejection of a fail, P_c, the largest {} ({})")  # fmt: skip
UNBOUNDED = (
    "单侧允许限且未约定 U 的上限：仅当 P_c ≥ 95 % 或 ≤ 5 % 时判定",
    "one-sided limits for which no largest U is agreed are decided on only if P_c ≥ 95 % or ≤ 5 %",
)
RULE = ("判定规则", "Decision rule")
GLOBAL = ("{}：用户风险 {}，生产方风险 {}", "{}: consumer's {}, producer's {}")


def conformity(decision: Decision) -> tuple[Field, ...]:
    """The fields of the statement; rule and risks only where something is limited."""
    return (
        Field(("判定依据", "Limits from"), given(decision.document)),
        *_rules(decision),
        *_specific(decision),
        *_global(decision),
        Field(("记号", "Marks"), _marks(decision)),
        Field(("结论", "Verdict"), cover.verdict(decision)),
    )


def conditions_of_a_pass(decision: Decision) -> tuple[Pair, ...]:
    """Every pass that lies within U of a limit, as a sentence."""
    return tuple(pair(zh, en) for en, zh in conditional(decision))


def _rules(decision: Decision) -> list[Field]:
    """Each rule in words; the items that it is for where there are several."""
    limits: dict[Pair, list[LimitDecision]] = {}
    for made in decision.limits:
        limits.setdefault(_rule(made), []).append(made)
    if len(limits) == 1:
        ((said, under),) = limits.items()
        return [Field(RULE, _with_figures(said, under))]
    fields = []
    for number, (said, under) in enumerate(limits.items(), start=1):
        of_zh, of_en = listed(item_name(name) for name in dict.fromkeys(m.item for m in under))
        zh, en = _with_figures(said, under)
        label = f"{RULE[0]} {number}", f"{RULE[1]} {number}"
        fields.append(Field(label, (f"{of_zh}：{zh}", f"{of_en}: {en}")))
    return fields


def _rule(made: LimitDecision) -> Pair:
    """The rule of one limit: its guard band, and what it asks of U."""
    factor = abs(made.guard_band_factor)
    w = "U" if factor == 1 else f"{factor:g} U"
    zh, en = ("内", "inside") if made.guard_band_factor >= 0 else ("外", "outside")
    said = [tuple(form.format(zh=zh, en=en, w=w) for form in RULES[made.rule])]
    if made.min_capability is not None and None not in (made.lower, made.upper):
        needed = f"C_m = T/(2 U) ≥ {max(made.min_capability, made.guard_band_factor):g}"
        said.append(
            (f"要求 {needed}，T 为允许区间宽度", f"decided on only if {needed}, with T the width")
        )
    one_sided = None in (made.lower, made.upper)
    if one_sided and made.guard_band_factor <= 0 and made.U_max is None:
        said.append(UNBOUNDED)
    return "，".join(zh for zh, _ in said), ", ".join(en for _, en in said)


def _with_figures(rule: Pair, under: list[LimitDecision]) -> Pair:
    """The rule with the bounds on U that were agreed and the coverage factors of U."""
    agreed = dict.fromkeys((made.item, plain(made.U_max), made.unit) for made in under)
    zh, en = [rule[0]], [rule[1]]
    for item, most, unit in agreed:
        if most is not None:
            bound = f"U ≤ {quantity_text(str(text(most)), unit)}"
            zh.append(f"{item_name(item)[0]}要求 {bound}")
            en.append(f"{item_name(item)[1]} decided on only if {bound}")
    factors = sorted({made.k for made in under if made.k is not None})
    if factors:
        k = " … ".join(f"{each:g}" for each in dict.fromkeys((factors[0], factors[-1])))
        zh.append(f"U 的 k = {k}")
        en.append(f"U has k = {k}")
    return pair("；".join(zh), "; ".join(en))


def _specific(decision: Decision) -> list[Field]:
    """The largest risk of the passes and of the fails, and whose it is."""
    accepting = [(m.false_acceptance, m) for m in decision.limits if m.false_acceptance is not None]
    rejecting = [(m.false_rejection, m) for m in decision.limits if m.false_rejection is not None]
    parts = [
        _largest(form, risks)
        for form, risks in ((ACCEPTING, accepting), (REJECTING, rejecting))
        if risks
    ]
    if not parts:
        return []
    zh, en = "；".join(zh for zh, _ in parts), "; ".join(en for _, en in parts)
    return [Field(("误判风险", "Risk of a wrong decision"), (SPECIFIC[0] + zh, SPECIFIC[1] + en))]


def _largest(form: Pair, risks: list[tuple[float, LimitDecision]]) -> Pair:
    risk, made = max(risks, key=lambda each: each[0])
    said = probability_text(risk), symbol(made.item, made.element)
    return form[0].format(*said), form[1].format(*said)


def _global(decision: Decision) -> list[Field]:
    """Risks over the production, for the worst element of each item that has a prior."""
    worst: dict[str, tuple[float, float]] = {}
    for made in decision.limits:
        if made.global_risks:
            consumer, producer = worst.get(made.item, (-math.inf, -math.inf))
            risks = made.global_risks
            worst[made.item] = max(consumer, risks.consumer), max(producer, risks.producer)
    said = [
        tuple(
            form.format(name, *map(probability_text, risks))
            for form, name in zip(GLOBAL, item_name(item), strict=True)
        )
        for item, risks in worst.items()
    ]
    if not said:
        return []
    zh, en = "；".join(zh for zh, _ in said), "; ".join(en for _, en in said)
    label = ("总体误判风险", "Risks over the production")
    return [Field(label, (f"{zh}（JCGM 106，9.5）", f"{en} (JCGM 106, 9.5)"))]


def _marks(decision: Decision) -> Pair:
    parts = [MARKS]
    if any(made.probability_of_conformity is not None for made in decision.limits):
        parts.append(CHANCES)
    if any(made.marginal for made in decision.limits):
        parts.append(NEAR)
    return "；".join(zh for zh, _ in parts), "; ".join(en for _, en in parts)
