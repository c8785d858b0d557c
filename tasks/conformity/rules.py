"""Decision rules: acceptance limits, and when no decision is made (JCGM 106, 8)."""

import math
from dataclasses import dataclass

from schemas.decision import GlobalRisks, Verdict
from schemas.tolerance import Limit, ProductionPrior, Rule, Tolerance

REACH = 12.0  # standard deviations from the mean beyond which a normal density is 0
Interval = tuple[float, float]
FULL_GUARD_BAND = 1.0  # w = U
USUAL_CAPABILITY = 1.0  # T = 2 U: U is half the interval of the limits
CLEAR = 0.95  # probability at which a one-sided limit without a bound on U is decided on


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
            return not 1.0 - CLEAR < conforms < CLEAR
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
