"""The verdict on a unit: its results against the limits of its product model.

Nothing passes by default: what is missing, not finite, too uncertain, not validated or measured
outside the conditions is inconclusive.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from schemas.base import Unusable
from schemas.calibration import Calibration, Elements, Item
from schemas.certificate import ConditionName
from schemas.recording import AXES, Standard
from schemas.station import Configuration
from schemas.text import Statement, texts_fields
from schemas.tolerance import (
    Decision,
    GlobalRisks,
    Limit,
    LimitDecision,
    ProductionPrior,
    Rule,
    Tolerance,
    Verdict,
)
from tasks.conformity.capabilities import taken_to_be_met
from tasks.conformity.limits import (
    Doubts,
    is_doubted,
    missing,
    outside,
    too_uncertain,
    without_uncertainty,
)
from tasks.specifications.estimate import ITEMS, second_value
from tasks.specifications.register import SPECIFICATIONS
from tasks.words import Message, Sayable, message, statement
from tasks.words.numbers import as_given, clause

# Decision rules: acceptance limits, and when no decision is made (JCGM 106, 8).

REACH = 12.0  # standard deviations from the mean beyond which a normal density is 0
Interval = tuple[float, float]
FULL_GUARD_BAND = 1.0  # w = U
USUAL_CAPABILITY = 1.0  # T = 2 U: U is half the interval of the limits
DECIDING_PROBABILITY = 0.95  # at which a one-sided limit without a bound on U is decided on


@dataclass(frozen=True)
class Criterion:
    """One limit with its rule, in the limit's unit; infinite where there is no limit.

    factor: r of the guard band w = r·U, by which the limits move inwards (outwards for r < 0);
    min_capability: smallest C_m, None where the rule asks for none; U_max: largest U.
    """

    lower: float
    upper: float
    rule: Rule
    factor: float
    min_capability: float | None
    U_max: float | None

    @property
    def limits(self) -> tuple[float, float]:
        return self.lower, self.upper

    def accepted(self, U: float) -> tuple[float, float]:
        """The acceptance interval for an expanded uncertainty (JCGM 106, 8.3.2 and 8.3.3)."""
        return self.lower + self.factor * U, self.upper - self.factor * U

    def capability(self, U: float) -> float:
        """C_m = T/(2·U), the measurement capability index (JCGM 106, 7.6); U > 0."""
        return (self.upper - self.lower) / (2 * U)

    @property
    def unbounded(self) -> bool:
        """Whether nothing bounds U: one limit alone, no guard band, no U_max.

        Simple acceptance presumes a bound on U (JCGM 106, 8.2.2); two limits give one by their
        distance, a guard band by what it takes from the acceptance interval.
        """
        one_sided = math.isinf(self.lower) or math.isinf(self.upper)
        return one_sided and self.factor <= 0.0 and self.U_max is None

    def decides(self, U: float, conforms: float) -> bool:
        """Whether U is small enough: for the rule, and to leave an acceptance interval.

        conforms: probability of conformity; where nothing bounds U it has to be clear itself.
        """
        if self.U_max is not None and self.U_max < U:
            return False
        if self.unbounded:
            return not 1.0 - DECIDING_PROBABILITY < conforms < DECIDING_PROBABILITY
        return self.capability(U) >= max(self.min_capability or 0.0, self.factor)

    def verdict(self, value: float, U: float, conforms: float) -> Verdict:
        """Pass inside the acceptance interval, limits included, else fail; U > 0.

        conforms: probability of conformity of the value. Inconclusive where U is too large. What
        lies outside its limits with the whole of value ± U fails however large U is.
        """
        wholly_outside = value + U < self.lower or value - U > self.upper
        if not self.decides(U, conforms):
            return "fail" if wholly_outside else "inconclusive"
        low, high = self.accepted(U)
        return "pass" if low <= value <= high else "fail"

    def marginal(self, value: float, U: float, verdict: Verdict) -> bool:
        """Whether a value lies nearer than U to a limit, or is accepted outside its limits."""
        outside = not self.lower <= value <= self.upper
        near = min(abs(value - self.lower), abs(value - self.upper)) < U
        return near or (outside and verdict == "pass")


def criterion(tolerance: Tolerance, limit: Limit) -> Criterion:
    """A limit with the rule that holds for it."""
    lower, upper = limit.bounds
    return Criterion(
        lower=-math.inf if lower is None else lower,
        upper=math.inf if upper is None else upper,
        rule=tolerance.rule_of(limit),
        factor=_guard_band_factor(tolerance, limit),
        min_capability=_min_capability(tolerance, limit),
        U_max=limit.U_max,
    )


def _guard_band_factor(tolerance: Tolerance, limit: Limit) -> float:
    """r of the guard band w = r·U of a limit; 0 where its rule has none (JCGM 106, 8.3)."""
    if tolerance.rule_of(limit) != "guard_band":
        return 0.0
    given = (limit.guard_band_factor, tolerance.guard_band_factor)
    return next((r for r in given if r is not None), FULL_GUARD_BAND)


def _min_capability(tolerance: Tolerance, limit: Limit) -> float | None:
    """Smallest C_m = T/(2·U) at which a limit with two sides is decided on.

    1 where nothing is given; None for a shared risk, whose parties agreed on U_max alone.
    """
    usual = None if tolerance.rule_of(limit) == "shared_risk" else USUAL_CAPABILITY
    return limit.min_capability or tolerance.min_capability or usual


def probability_of_conformity(
    value: float, u: float, limits: Interval, dof: float = math.inf
) -> float:
    """Probability that the measured quantity lies inside its limits (JCGM 106, 7.2 to 7.4).

    The knowledge of the quantity is a normal distribution about the value with the standard
    uncertainty u > 0, or, for finite degrees of freedom, a t distribution of that scale
    (JCGM 101, 6.4.9). A limit that is not there is infinite. Nothing else is known of the
    quantity: no prior is used.
    """
    lower, upper = ((limit - value) / u for limit in limits)
    # In the tail where both are small, or 1 − 1 would be left of a small probability.
    if lower > 0:
        lower, upper = -upper, -lower
    return min(max(_below(upper, dof) - _below(lower, dof), 0.0), 1.0)


def _below(z: float, dof: float) -> float:
    from scipy.special import ndtr, stdtr  # late: a tenth of a start

    return float(ndtr(z) if math.isinf(dof) else stdtr(dof, z))


def probability_of_nonconformity(
    value: float, u: float, limits: Interval, dof: float = math.inf
) -> float:
    """Probability that the measured quantity lies outside its limits; small ones are kept."""
    lower, upper = ((limit - value) / u for limit in limits)
    return min(_below(lower, dof) + _below(-upper, dof), 1.0)


def global_risks(
    prior: ProductionPrior, u: float, limits: Interval, accepted: Interval
) -> GlobalRisks:
    """Risks over the production that the prior describes (JCGM 106, 9.5.2).

    A true value η is drawn from the prior and measured with a normal error of standard
    uncertainty u > 0. Consumer: η outside the limits, its measured value accepted; producer: η
    inside, its measured value not accepted.
    """
    below, inside, above = (
        _joint(prior, u, part, accepted)
        for part in ((-math.inf, limits[0]), limits, (limits[1], math.inf))
    )
    conform = probability_of_conformity(prior.mean, prior.sd, limits)
    return GlobalRisks(consumer=_proper(below + above), producer=_proper(conform - inside))


def _joint(prior: ProductionPrior, u: float, part: Interval, accepted: Interval) -> float:
    """Probability that a true value lies in a part and its measured value is accepted."""
    from scipy.integrate import quad

    reach = REACH * prior.sd
    low, high = max(part[0], prior.mean - reach), min(part[1], prior.mean + reach)
    if low >= high:
        return 0.0

    def density(true: float) -> float:
        z = (true - prior.mean) / prior.sd
        normal = math.exp(-z * z / 2) / (prior.sd * math.sqrt(2 * math.pi))
        return normal * probability_of_conformity(true, u, accepted)

    # The acceptance falls off within a few u of its limits: the integral is told where.
    turns = [edge + n * u for edge in (*accepted, prior.mean) for n in (-4, -1, 0, 1, 4)]
    places = [place for place in turns if low < place < high]
    return float(quad(density, low, high, points=places or None, limit=500)[0])


def _proper(probability: float) -> float:
    return min(max(probability, 0.0), 1.0)


WHOLE_ITEM = ("all",)  # an item of which nothing is known but that it is unavailable


def decide(
    calibration: Calibration,
    tolerance: Tolerance | None,
    doubts: tuple[Sayable, ...] = (),
    doubts_of: Doubts | None = None,
) -> Decision:
    """The verdict on a calibration, limit by limit and overall.

    Fail if any limited element fails by its decision rule; else inconclusive if a limited element
    has no value, no uncertainty above zero or one too large for its rule, if a remark blocks a
    pass, if U of a limited element rests on limits of a specification that the equipment is only
    assumed to meet, if there are `doubts` (further reasons, such as those of `expired`), or if
    there is no tolerance; else pass. `doubts_of` an item, by its name, leave its limited elements
    undecided whatever their values, and do not count if none is limited.

    An invalid run gives no verdict on any element, neither pass nor fail: only its reasons count.

    A fail outranks the remarks that block a pass and the doubts about the whole run: they say that
    conformity was not shown, and a value outside its limits does not show it either. To reject too
    often costs a repetition, which the reasons name; to hide a failing value behind an open
    condition would let a bad unit pass as merely undecided.

    Raises Unusable if the tolerance does not apply to this calibration: unknown item or element,
    another unit.
    """
    doubts_of = doubts_of or {}
    decisions = tuple(_decisions(calibration, tolerance, doubts_of)) if tolerance else ()
    reasons: list[Sayable] = [] if tolerance else [message("conformity-no-tolerance")]
    if calibration.validity.verdict == "invalid":
        reasons.insert(0, message("conformity-invalid-run"))
    else:
        reasons += _reasons(calibration, decisions, doubts_of)
        reasons += taken_to_be_met(calibration, decisions)
    doubted = (each.item for each in decisions if is_doubted(doubts_of, each.item, each.element))
    reasons += [doubts_of[item].sentence for item in dict.fromkeys(doubted)]
    reasons += doubts
    reasons += [remark for remark in calibration.remarks if remark.blocks_pass]
    statements = tuple(dict.fromkeys(map(statement, reasons)))
    verdict = _overall(decisions, statements)
    return Decision(
        verdict=verdict,
        rule=tolerance.rule if tolerance else "simple_acceptance",
        document=tolerance.document if tolerance else None,
        limits=decisions,
        **texts_fields("reasons", statements),
        marginal=_marginal(decisions, verdict),
    )


def _overall(decisions: tuple[LimitDecision, ...], reasons: tuple[Statement, ...]) -> Verdict:
    if any(decided.verdict == "fail" for decided in decisions):
        return "fail"
    if decisions and not reasons and all(decided.verdict == "pass" for decided in decisions):
        return "pass"
    return "inconclusive"


def _marginal(decisions: tuple[LimitDecision, ...], verdict: Verdict) -> bool:
    """One doubtful element makes a pass conditional; one beyond doubt makes a fail a plain one."""
    marks = [decided.marginal for decided in decisions if decided.verdict == verdict]
    return {"pass": any(marks), "fail": all(marks), "inconclusive": False}[verdict]


def _decisions(
    calibration: Calibration, tolerance: Tolerance, doubts_of: Doubts
) -> Iterator[LimitDecision]:
    for limit in tolerance.limits:
        check(calibration, limit)
        item, rule = calibration.items.get(limit.item), criterion(tolerance, limit)
        undecided = withdrawn(calibration, limit.item)
        undecided = undecided or calibration.validity.verdict == "invalid"
        for element in limited(item, limit):
            doubted = is_doubted(doubts_of, limit.item, element)
            yield _decision(limit, rule, element, item, undecided or doubted)


def _decision(
    limit: Limit, rule: Criterion, element: str, item: Item | None, undecided: bool
) -> LimitDecision:
    """The verdict on one element, by its U where that is above zero."""
    value = _at(getattr(item, limit.applied_to), element) if item else None
    U = _expanded_uncertainty(item, limit, element) if item else None
    accepted = _acceptance_interval(rule, U)
    verdict: dict[str, Any] = {"verdict": "inconclusive"}
    if item and U and value is not None and not undecided:
        budget = item.budgets.get(element)
        dof = budget.dof if budget else math.inf
        verdict = _verdict(limit, rule, value, U, U / item.k, dof)
    return LimitDecision(
        item=limit.item,
        element=element,
        unit=limit.unit,
        applied_to=limit.applied_to,
        value=value,
        U=U,
        k=item.k if item else None,
        lower=_finite(rule.lower),
        upper=_finite(rule.upper),
        nominal=limit.nominal,
        rule=rule.rule,
        guard_band_factor=rule.factor,
        accept_lower=accepted[0],
        accept_upper=accepted[1],
        capability=_finite(rule.capability(U)) if U else None,
        min_capability=rule.min_capability,
        U_max=rule.U_max,
        **verdict,
    )


def _acceptance_interval(rule: Criterion, U: float | None) -> tuple[float | None, float | None]:
    """The acceptance limits; none where U is so large that they would have changed sides."""
    low, high = rule.accepted(U) if U else (math.nan, math.nan)
    return (_finite(low), _finite(high)) if low <= high else (None, None)


def _expanded_uncertainty(item: Item, limit: Limit, element: str) -> float | None:
    """U of the quantity that a limit is applied to, where it is above zero."""
    without_earth = limit.applied_to == "value_without_earth_rotation"
    own = item.U_without_earth_rotation if without_earth else None
    U = _at(own or item.U, element)
    return U if U and U > 0 else None


def _verdict(
    limit: Limit, rule: Criterion, value: float, U: float, u: float, dof: float
) -> dict[str, Any]:
    """The verdict with its risk; dof: those of the element's budget, infinite without one."""
    about = (value, u, rule.limits, dof)
    conforms, not_so = probability_of_conformity(*about), probability_of_nonconformity(*about)
    verdict = rule.verdict(value, U, conforms)
    if verdict == "inconclusive":
        shown = {"probability_of_conformity": conforms} if rule.unbounded else {}
        return {"verdict": verdict, **shown}
    accepted = verdict == "pass"
    risk: dict[str, Any] = {
        "false_acceptance": not_so if accepted else None,
        "false_rejection": None if accepted else conforms,
    }
    if limit.prior:
        risk["global_risks"] = global_risks(limit.prior, u, rule.limits, rule.accepted(U))
    return {
        "verdict": verdict,
        "marginal": rule.marginal(value, U, verdict),
        "probability_of_conformity": conforms,
        **risk,
    }


def _at(values: Elements | None, element: str) -> float | None:
    return _finite((values or {}).get(element))


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _reasons(
    calibration: Calibration, decisions: tuple[LimitDecision, ...], doubts_of: Doubts
) -> list[Message]:
    """Why limited elements did not pass: outside, too uncertain, without U, without a value."""
    undecided = [d for d in decisions if d.verdict == "inconclusive"]
    absent = [d for d in undecided if d.value is None or withdrawn(calibration, d.item)]
    bare = [d for d in undecided if d not in absent and d.U is None]
    explained = [*absent, *bare]
    vague = [
        d for d in undecided if d not in explained and not is_doubted(doubts_of, d.item, d.element)
    ]
    return [
        *(outside(decided) for decided in decisions if decided.verdict == "fail"),
        *map(too_uncertain, vague),
        *without_uncertainty(bare),
        *missing(calibration, absent),
    ]


def check(calibration: Calibration, limit: Limit) -> None:
    """Raises Unusable for an unknown item, element or quantity, or another unit."""
    place = f"The tolerance limits {limit.item}"
    item = calibration.items.get(limit.item)
    if item is None and limit.item not in calibration.unavailable:
        known = ", ".join(sorted({*calibration.items, *calibration.unavailable}))
        raise Unusable(
            f"{place}, which calibration {calibration.run} by {calibration.method} does not "
            f"have: name one of {known}, or remove the limit."
        )
    unit = item.unit if item else ITEMS[limit.item].unit if limit.item in ITEMS else limit.unit
    if limit.unit != unit:
        raise Unusable(
            f"{place} in {limit.unit!r} but the result is in {unit!r}: give the limit in {unit!r}."
        )
    known_elements = _elements(item, limit.item)
    strange = [element for element in limit.elements or () if element not in known_elements]
    if limit.elements == () or (strange and known_elements != WHOLE_ITEM):
        raise Unusable(
            f"{place} for the elements {strange}, but this item has "
            f"{', '.join(known_elements)}: name some of these or leave `elements` out."
        )
    if limit.applied_to not in ("value", second_value(limit.item)):
        raise Unusable(
            f"{place} with applied_to = {limit.applied_to!r}, a quantity that this item does not "
            "have: apply the limit to 'value'."
        )


def limited(item: Item | None, limit: Limit) -> tuple[str, ...]:
    """The elements that a limit is about."""
    return limit.elements or _elements(item, limit.item)


def withdrawn(calibration: Calibration, name: str) -> bool:
    """Whether an item is unavailable as a whole although all its numbers are there."""
    item = calibration.items.get(name)
    if name not in calibration.unavailable or item is None:
        return name in calibration.unavailable
    second = getattr(item, second_value(name) or "value")
    return second is not None and None not in (*item.value.values(), *second.values())


def _elements(item: Item | None, name: str) -> tuple[str, ...]:
    """Every element the item has; those of the specification also where the result lacks them."""
    named = ITEMS[name].elements if name in ITEMS else ()
    return tuple(dict.fromkeys((*named, *(item.value if item else ())))) or WHOLE_ITEM


# Conditions of the specification that were not met, or were not checked.

# Where a specification asks for the largest input rate; JJF 1536 asks for rates within the range.
LARGEST_RATE: dict[Standard, str] = {"JJF 2003-2022": "JJF 2003-2022, 7.2.1.1 c)"}
FULL_SCALE = 0.999  # of the unit's largest input rate counts as that rate
NOT_RECORDED = {"environment_not_recorded", "environment_in_part"}  # remarks on the air


@dataclass(frozen=True)
class Deviation:
    """A condition by its name, what is missing, and whether the client waives it."""

    name: ConditionName
    sentence: Sayable
    waived: bool

    @property
    def printed(self) -> Message:
        """The deviation as printed on the certificate, and among the reasons if it prevents a
        pass.
        """
        kind = "waived" if self.waived else "open"
        condition = message(f"conformity-waivable.{self.name.replace('_', '-')}")
        return message(f"conformity-deviation.{kind}", name=condition, sentence=self.sentence)


def deviations(
    calibration: Calibration, configuration: Configuration, waived: Iterable[ConditionName] = ()
) -> tuple[Deviation, ...]:
    """Every condition that was not shown to be met, in the order of the specification."""
    waived = set(waived)
    found: list[tuple[ConditionName, Sayable]] = []
    rates = largest_rate(calibration, configuration)
    if rates is not None and not rates.included:
        found.append(("largest_rate", rates.sentence))
    found += [
        ("environment", remark) for remark in calibration.remarks if remark.code in NOT_RECORDED
    ]
    return tuple(Deviation(name, sentence, name in waived) for name, sentence in found)


@dataclass(frozen=True)
class LargestRate:
    """Whether the unit was turned at its largest input rate about every axis, as a sentence."""

    included: bool
    sentence: Message


def largest_rate(calibration: Calibration, configuration: Configuration) -> LargestRate | None:
    """None where nothing was turned at a rate, or the specification does not ask for that rate."""
    where = LARGEST_RATE.get(SPECIFICATIONS[calibration.method].standard)
    held = [segment for segment in calibration.segments if segment.kind == "rate"]
    if where is None or not held:
        return None
    largest, at = configuration.rate_range_deg_s, clause(where)
    if largest is None:
        return LargestRate(False, message("conformity-largest-rate.not-given", clause=at))
    reached = dict.fromkeys(AXES, 0.0)
    for segment in held:
        if segment.axis:
            rate = abs(segment.rate_deg_s or 0.0)
            reached[segment.axis] = max(reached[segment.axis], rate)
    short = [axis for axis in AXES if reached[axis] < FULL_SCALE * largest]
    kind = "missed" if short else "included"
    sentence = message(
        f"conformity-largest-rate.{kind}", clause=at, largest=as_given(largest),
        axes=", ".join(axis.upper() for axis in short),
        reached=as_given(min((reached[axis] for axis in short), default=0.0)),
    )  # fmt: skip
    return LargestRate(not short, sentence)
