"""By how much effects explain the same runs: what names are compared by."""

import numpy as np

from tasks.review.carriers import Carried
from tasks.review.evidence import Evidence, solved
from tasks.review.hypotheses import Effect
from tasks.review.pool import Pool
from tasks.review.random_effects import BETWEEN_UNITS, Spread, spreads
from tasks.review.windows import rows_of


def explains(pool: Pool, one: Carried, rows: np.ndarray, beside: Carried) -> float:
    """Twice the nats by which an effect explains some runs (runs,) bool, given all others, less the
    price: ln p(some | others) against no effect and no spread.

    The gains of two effects are not comparable: one's spread may have taken part of the same
    readings before. Nor are the likelihoods of all runs: what an effect's spread explains in other
    runs is no reason to name it in these. The spread is the effect's own, or that between units of
    another, `beside`, if that is likelier: that units differ in one effect does not make it the
    name of what a carrier has.
    """
    sigma, tau = one.spread.sigma, one.spread.tau
    others = likeliest(one.evidence.of(~rows), (sigma,), (tau,))
    value = one.total - 2.0 * others.likelihood
    if beside.spread.tau and beside.effect != one.effect:
        taus = (beside.spread.tau,)
        spread = likeliest(beside.evidence, (0.0,), taus)
        others = likeliest(beside.evidence.of(~rows), (0.0,), taus)
        gain = gain_beside(pool, one, beside.effect, spread)
        value = max(value, 2.0 * (spread.likelihood - others.likelihood) + gain - one.price)
    return value


def likeliest(evidence: Evidence, sigmas: tuple[float, ...], taus: tuple[float, ...]) -> Spread:
    """The likeliest spread of those tried."""
    return max(spreads(evidence, sigmas, taus), key=lambda each: each.likelihood)


def usual(evidence: Evidence, rows: np.ndarray) -> Spread | None:
    """The spread of an effect between units in all runs, as large as those but some (runs,) bool
    show it; None where they show none.
    """
    tau = likeliest(evidence.of(~rows), (0.0,), BETWEEN_UNITS).tau
    return likeliest(evidence, (0.0,), (tau,)) if tau else None


def gain_beside(pool: Pool, one: Carried, other: Effect, spread: Spread) -> float:
    """Chi-squared that the common value of an effect takes away beside the spread of another
    between units: as `Spread.common`, with the information that the two share for that of one.
    """
    rows = np.flatnonzero(rows_of(pool, one.window))
    evidence = one.evidence
    shared = evidence.back.T @ pool.shared(one.effect, other, rows) @ spread.evidence.back
    own = np.zeros((len(spread.kept), *shared.shape[1:]))  # of each unit
    np.add.at(own, evidence.unit[rows], shared)
    right = evidence.score[rows].sum(axis=0) - np.einsum("uij,uj->i", own, spread.shrunk)
    information = evidence.information[rows].sum(axis=0)
    information -= np.einsum("uij,ujk,ulk->il", own, spread.lessened, own)
    crossed = np.einsum("uij,ujk->ik", own, spread.kept)
    right -= crossed @ spread.everywhere
    information -= crossed @ spread.shared @ crossed.T
    return float(right @ solved(information, right))
