"""Why a unit does not pass, as sentences: (English, Chinese)."""

from collections.abc import Iterable
from decimal import Decimal

from schemas.calibration import Calibration
from schemas.tolerance import Decision, LimitDecision
from tasks.certificate.limits import (
    accepted_text,
    limits_text,
    plain,
    probability_text,
    relative_text,
)
from tasks.certificate.names import CONDITIONAL, QUANTITIES, item_name, symbol
from tasks.specifications.items import second_value
from tasks.words.rounding import USUAL_K, round_like, round_up, text
from tasks.words.units import quantity_text

Reason = tuple[str, str]  # English, Chinese

NO_CAUSE = ("no cause was given", "未说明原因")


def outside(made: LimitDecision) -> Reason:
    """A value that fails by its rule, with its uncertainty and the risk of having rejected it."""
    en, zh = _measured(made)
    where_en, where_zh = _where(made)
    risk_en, risk_zh = _risk(made)
    return f"{en}, {where_en}{risk_en}", f"{zh}，{where_zh}{risk_zh}"


def conditional(decision: Decision) -> list[Reason]:
    """One sentence for each pass that lies within U of a limit, or outside it."""
    said = []
    for made in decision.limits:
        if made.marginal and made.verdict == "pass":
            (en, zh), (risk_en, risk_zh) = _measured(made), _risk(made)
            where_en, where_zh = "within U of its limit", "距允许限 {} 小于 U"
            if not _inside(Decimal(repr(made.value)), made.lower, made.upper):
                where_en, where_zh = "outside its limit", "超出允许限 {}"
            limits = _limits(made)
            said.append(
                (
                    f"{en}, is accepted but lies {where_en}, {limits}{risk_en}",
                    f"{zh}，判为符合，但{where_zh.format(limits)}{risk_zh}",
                )
            )
    return said


def too_uncertain(made: LimitDecision) -> Reason:
    """A value whose uncertainty is larger than its rule allows."""
    (en, zh), limits = _decided_on(made), _limits(made)
    measured, U = _value(made), _uncertainty(made)
    if made.U_max is not None and made.U is not None and made.U_max < made.U:
        most = quantity_text(str(text(plain(made.U_max))), made.unit)
        why_en, why_zh = f"larger than the agreed {most}", f"大于约定的 {most}"
    elif made.probability_of_conformity is not None:
        chance = probability_text(made.probability_of_conformity)
        why_en = (
            f"the probability of conformity with {limits} is {chance}, and nothing bounds U: state "
            "U_max, the largest U at which this limit is decided on"
        )
        why_zh = f"相对允许限 {limits} 的合格概率为 {chance}，且 U 无上限约定：请给出 U_max"
    elif (needed := max(made.min_capability or 0.0, made.guard_band_factor)) > 1:
        why_en = f"C_m = T/(2 U) = {made.capability:.2g} for {limits}, below {needed:g}"
        why_zh = f"允许区间 {limits} 的 C_m = T/(2 U) = {made.capability:.2g}，小于 {needed:g}"
    else:
        why_en = f"larger than half the interval {limits}"
        why_zh = f"大于允许区间 {limits} 的一半"
    return (
        f"{en}: {measured}, U = {U}, {why_en}: nothing can be decided",
        f"{zh}：{measured}，U = {U}，{why_zh}，无法判定",
    )


def without_uncertainty(decisions: Iterable[LimitDecision]) -> list[Reason]:
    """One reason for each item that has values without an uncertainty above zero."""
    return [
        (
            f"{en} ({listed}): no uncertainty above zero was found, so nothing can be decided",
            f"{zh}（{listed}）：未得到大于零的不确定度，无法判定",
        )
        for _, (zh, en), listed in _by_item(decisions)
    ]


def missing(calibration: Calibration, decisions: Iterable[LimitDecision]) -> list[Reason]:
    """One reason for each item that has elements without a value."""
    reasons = []
    for name, (zh, en), listed in _by_item(decisions):
        why = calibration.unavailable.get(name)
        why_zh = calibration.unavailable_zh.get(name) or why
        reasons.append(
            (
                f"{en} ({listed}) not determined: {why or NO_CAUSE[0]}",
                f"{zh}（{listed}）未得：{why_zh or NO_CAUSE[1]}",
            )
        )
    return reasons


def _by_item(
    decisions: Iterable[LimitDecision],
) -> list[tuple[str, tuple[str, str], str]]:
    """Item, its name (Chinese, English) and the list of its elements."""
    elements: dict[str, list[str]] = {}
    for made in decisions:
        elements.setdefault(made.item, []).append(made.element)
    return [
        (name, item_name(name), ", ".join(dict.fromkeys(listed)))
        for name, listed in elements.items()
    ]


def _decided_on(made: LimitDecision) -> Reason:
    """Item, symbol and, where the item has two values, the one that was decided on."""
    (zh, en), short = item_name(made.item), symbol(made.item, made.element)
    if second_value(made.item) is None:
        return f"{en} {short}", f"{zh} {short}"
    which_zh, which_en = QUANTITIES[made.applied_to]
    return f"{en} {short}, {which_en}", f"{zh} {short}，{which_zh}"


def _measured(made: LimitDecision) -> Reason:
    (en, zh), measured, U = _decided_on(made), _value(made), _uncertainty(made)
    k = "" if made.k is None else f"{made.k:g}"
    return f"{en}: {measured}, U = {U} (k = {k})", f"{zh}：{measured}，U = {U}（k = {k}）"


def _where(made: LimitDecision) -> Reason:
    """Outside the limits, or inside them but in the guard band."""
    limits = _limits(made)
    if not _inside(Decimal(repr(made.value)), made.lower, made.upper):
        return f"is outside {limits}", f"超出 {limits}"
    accepted = quantity_text(str(accepted_text(made)), made.unit)
    return (
        f"is inside {limits} but outside the acceptance limits {accepted}",
        f"在允许限 {limits} 内，但超出接受限 {accepted}",
    )


def _risk(made: LimitDecision) -> Reason:
    """The risk of a verdict, and whether it is a conditional one."""
    en = zh = ""
    if made.marginal:
        mark_zh, mark_en = CONDITIONAL[made.verdict]
        zh, en = f"{mark_zh}，", f"{mark_en}, "
    if made.false_acceptance is not None:
        chance = probability_text(made.false_acceptance)
        return f" ({en}false acceptance {chance})", f"（{zh}错误接受概率 {chance}）"
    if made.false_rejection is not None:
        chance = probability_text(made.false_rejection)
        return f" ({en}false rejection {chance})", f"（{zh}错误拒绝概率 {chance}）"
    return "", ""


def _value(made: LimitDecision) -> str:
    """The value rounded to the place of U; in full where that would hide what was decided."""
    assert made.value is not None  # else nothing was decided
    full, rounded = Decimal(repr(made.value)), round_like(made.value, _rounded(made))
    shown = rounded if _sides(rounded, made) == _sides(full, made) else full
    return quantity_text(str(text(shown)), made.unit)


def _sides(value: Decimal, made: LimitDecision) -> tuple[bool, bool]:
    """Whether a value is inside the limits, and inside the acceptance limits."""
    return (
        _inside(value, made.lower, made.upper),
        _inside(value, made.accept_lower, made.accept_upper),
    )


def _inside(value: Decimal, lower: float | None, upper: float | None) -> bool:
    above = lower is None or value >= Decimal(repr(lower))
    return above and (upper is None or value <= Decimal(repr(upper)))


def _rounded(made: LimitDecision) -> Decimal:
    assert made.U is not None  # else nothing was decided
    return round_up(made.U, made.k or USUAL_K)


def _uncertainty(made: LimitDecision) -> str:
    return quantity_text(str(text(_rounded(made))), made.unit)


def _limits(made: LimitDecision) -> str:
    wanted, given = quantity_text(limits_text(made), made.unit), relative_text(made)
    return f"{wanted} ({given})" if given else wanted
