"""Probabilities of conformity and the risks of a decision (JCGM 106, 7 and 9)."""

import math

from schemas.decision import GlobalRisks
from schemas.tolerance import ProductionPrior

REACH = 12.0  # standard deviations from the mean beyond which a normal density is 0
Interval = tuple[float, float]


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
