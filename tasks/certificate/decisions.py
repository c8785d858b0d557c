"""The statement of conformity: limits, decision rules, risks of a wrong decision, verdict."""

from schemas.decision import Decision, GlobalRisks, LimitDecision
from tasks.certificate import cover
from tasks.certificate.fields import Field, field, given, slug
from tasks.conformity.limits import nothing_accepted, probability_text
from tasks.specifications.items import item_title, symbol
from tasks.words import Message, Sayable, clauses, message
from tasks.words.quantities import quantity_text
from tasks.words.rounding import exact, text


def conformity(decision: Decision) -> tuple[Field, ...]:
    """The fields of the statement; rule and risks only where something is limited."""
    return (
        field("limits-from", given(decision.document)),
        *_rules(decision),
        *_specific_risks(decision),
        *_global_risks(decision),
        field("marks", _marks(decision)),
        field("verdict", cover.verdict(decision)),
    )


def _rules(decision: Decision) -> list[Field]:
    """Each rule in words; the items that it is for where there are several."""
    limits: dict[Message, list[LimitDecision]] = {}
    for limit in decision.limits:
        limits.setdefault(_rule(limit), []).append(limit)
    if len(limits) == 1:
        ((rule, under),) = limits.items()
        return [field("rule", _with_figures(rule, under))]
    fields = []
    for number, (rule, under) in enumerate(limits.items(), start=1):
        items = tuple(map(item_title, dict.fromkeys(limit.item for limit in under)))
        of_items = message("certificate-rule-of", items=items, rule=_with_figures(rule, under))
        fields.append(Field(message("certificate-field.rule-number", number=number), of_items))
    return fields


def _rule(limit: LimitDecision) -> Message:
    """The rule of one limit: its guard band, and what it asks of U."""
    factor = abs(limit.guard_band_factor)
    side = "-outwards" if limit.rule == "guard_band" and limit.guard_band_factor < 0 else ""
    w = "U" if factor == 1 else f"{factor:g} U"
    rule = message(f"certificate-rule.{slug(limit.rule)}{side}", w=w)
    one_sided = None in (limit.lower, limit.upper)
    if limit.min_capability is not None and not one_sided:
        needed = max(limit.min_capability, limit.guard_band_factor)
        rule = message("certificate-rule.capability", rule=rule, needed=f"{needed:g}")
    if one_sided and limit.guard_band_factor <= 0 and limit.U_max is None:
        rule = message("certificate-rule.unbounded", rule=rule)
    return rule


def _with_figures(rule: Sayable, under: list[LimitDecision]) -> Sayable:
    """The rule with the bounds on U that were agreed and the coverage factors of U."""
    parts: list[Sayable] = [rule]
    for item, largest, unit in dict.fromkeys((m.item, exact(m.U_max), m.unit) for m in under):
        if largest is not None:
            U_max = quantity_text(str(text(largest)), unit)
            parts.append(message("certificate-rule.bound", item=item_title(item), U_max=U_max))
    factors = sorted({limit.k for limit in under if limit.k is not None})
    if factors:
        k = " … ".join(f"{k:g}" for k in dict.fromkeys((factors[0], factors[-1])))
        parts.append(message("certificate-rule.coverage-factor", k=k))
    return clauses(parts)


def _specific_risks(decision: Decision) -> list[Field]:
    """The largest risk of the passes and of the fails, and whose it is."""
    parts = []
    for kind in ("acceptance", "rejection"):
        risks = [
            (risk, limit)
            for limit in decision.limits
            if (risk := getattr(limit, f"false_{kind}")) is not None
        ]
        if risks:
            risk, limit = max(risks, key=lambda pair: pair[0])
            chance, whose = probability_text(risk), symbol(limit.item, limit.element)
            parts.append(message(f"certificate-risk.{kind}", chance=chance, symbol=whose))
    return [field("risk", message("certificate-risk", parts=clauses(parts)))] if parts else []


def _global_risks(decision: Decision) -> list[Field]:
    """Risks over the production, for the worst element of each item that has a prior."""
    risks: dict[str, list[GlobalRisks]] = {}
    for limit in decision.limits:
        if limit.global_risks:
            risks.setdefault(limit.item, []).append(limit.global_risks)
    parts = [
        message(
            "certificate-global-risk.item", item=item_title(item),
            consumer=probability_text(max(risk.consumer for risk in of_item)),
            producer=probability_text(max(risk.producer for risk in of_item)),
        )
        for item, of_item in risks.items()
    ]  # fmt: skip
    if not parts:
        return []
    return [field("global-risk", message("certificate-global-risk", parts=clauses(parts)))]


def _marks(decision: Decision) -> Sayable:
    parts = [message("certificate-marks.absent")]
    if any(limit.probability_of_conformity is not None for limit in decision.limits):
        parts.append(message("certificate-marks.chance"))
    if any(limit.marginal for limit in decision.limits):
        parts.append(message("certificate-marks.conditional"))
    if any(map(nothing_accepted, decision.limits)):
        parts.append(message("certificate-marks.nothing-accepted"))
    return clauses(parts)
