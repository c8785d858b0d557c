"""Why a unit does not pass, as sentences: (English, Chinese)."""

from collections.abc import Iterable
from decimal import Decimal

from schemas.calibration import Calibration
from schemas.tolerance import LimitDecision
from tasks.certificate.names import QUANTITIES, SECOND_VALUE, item_name, quantity_text, symbol
from tasks.uncertainty.rounding import round_like, round_up, text

Reason = tuple[str, str]  # English, Chinese

NO_CAUSE = ("no cause was given", "未说明原因")


def outside(made: LimitDecision, k: float) -> Reason:
    """A value that fails its limit, with its uncertainty; k: the coverage factor of U."""
    en, zh = _decided_on(made)
    measured, U, limits = _value(made), _uncertainty(made), _limits(made)
    return (
        f"{en}: {measured}, U = {U} (k = {k:g}), is outside {limits}",
        f"{zh}：{measured}，U = {U}（k = {k:g}），超出 {limits}",
    )


def too_uncertain(made: LimitDecision) -> Reason:
    """A value whose uncertainty is larger than half the interval of its limits."""
    en, zh = _decided_on(made)
    measured, U, limits = _value(made), _uncertainty(made), _limits(made)
    return (
        f"{en}: {measured}, U = {U}, larger than half the interval {limits}: nothing can be "
        "decided",
        f"{zh}：{measured}，U = {U}，大于允许区间 {limits} 的一半，无法判定",
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
    if made.item not in SECOND_VALUE:
        return f"{en} {short}", f"{zh} {short}"
    which_zh, which_en = QUANTITIES[made.applied_to]
    return f"{en} {short}, {which_en}", f"{zh} {short}，{which_zh}"


def _value(made: LimitDecision) -> str:
    """The value rounded to the place of U; in full where that would hide what was decided."""
    assert made.value is not None  # else nothing was decided
    assert made.U is not None
    full, rounded = Decimal(repr(made.value)), round_like(made.value, round_up(made.U))
    shown = rounded if _inside(rounded, made) == _inside(full, made) else full
    return quantity_text(str(text(shown)), made.unit)


def _inside(value: Decimal, made: LimitDecision) -> bool:
    above = made.lower is None or value >= Decimal(repr(made.lower))
    return above and (made.upper is None or value <= Decimal(repr(made.upper)))


def _uncertainty(made: LimitDecision) -> str:
    assert made.U is not None
    return quantity_text(str(text(round_up(made.U))), made.unit)


def _limits(made: LimitDecision) -> str:
    lower, upper = (None if x is None else text(_plain(x)) for x in (made.lower, made.upper))
    if made.lower is None or made.upper is None:
        wanted = f"≤ {upper}" if made.lower is None else f"≥ {lower}"
    elif made.lower == -made.upper:
        wanted = f"±{upper}"
    else:
        wanted = f"{lower} … {upper}"
    return quantity_text(wanted, made.unit)


def _plain(number: float) -> Decimal:
    return Decimal(repr(number)).normalize()
