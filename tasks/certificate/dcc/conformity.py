"""The statement of conformity: on the unit, and on each element that has a limit."""

from schemas.decision import Decision, LimitDecision
from tasks.certificate.dcc.quantities import plain_quantity, ref_type
from tasks.certificate.dcc.units import DsiUnit
from tasks.certificate.dcc.xml import Element, dcc, described, named, plain
from tasks.conformity.limits import accepted_edges, probability_text, verdict_title
from tasks.words import Sayable, message
from tasks.words.rounding import exact

CONFORMITY = "basic_conformity"


def status(decided: Decision | LimitDecision) -> list[Element]:
    """DCC's word for a verdict; none where nothing could be decided."""
    if decided.verdict == "inconclusive":
        return []
    verdict: str = decided.verdict
    word = f"conditional{verdict.capitalize()}" if decided.marginal else verdict
    return [dcc.conformity(word)]


def conformity(limit: LimitDecision, unit: DsiUnit) -> Element:
    """One element against its limits, the limits and the acceptance limits as numbers."""
    chance = limit.probability_of_conformity
    lower, upper = accepted_edges(limit) or (None, None)
    edges = [
        plain_quantity(message(f"dcc-limit.{name}"), number, unit, refType=ref_type(name))
        for name, number in (
            ("lower", exact(limit.lower)), ("upper", exact(limit.upper)),
            ("accept-lower", lower), ("accept-upper", upper),
        )
        if number is not None
    ]  # fmt: skip
    sentences: list[Sayable] = [verdict_title(limit)]
    if chance is not None:
        sentences.append(message("dcc-chance", chance=probability_text(chance)))
    return dcc.metaData(
        named(message("certificate-label-conformity")),
        described(*sentences, tag="declaration"),
        *status(limit),
        *([dcc.data(*edges)] if edges else []),
        refType=CONFORMITY,
    )


def verdict(decision: Decision, *sentences: Sayable) -> Element:
    """The verdict on the unit."""
    return dcc.statement(
        named(message("certificate-label-conformity")),
        *([plain("reference", decision.document)] if decision.document else []),
        described(*sentences, tag="declaration"),
        *(status(decision) if decision.limits else []),
        refType=CONFORMITY,
    )
