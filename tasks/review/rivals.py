"""Alternative explanations of a finding: other effects and other carriers."""

from collections.abc import Sequence

import numpy as np
from scipy.special import chdtrc

from schemas.review import Level
from tasks.explain.odds import CERTAIN, as_likely_within
from tasks.explain.search.scores import PER_PARAMETER
from tasks.explain.search.special_case import HOLDS
from tasks.review.carriers import Carried, carried
from tasks.review.comparison import explains, gain_beside, usual
from tasks.review.pool import Pool
from tasks.review.screening import Worth
from tasks.review.windows import rows_of

COMMON = 0.5  # of the runs of a finding: another that has them explains the same readings
INTERVALS = 50  # of a run that show an effect


def at_window_of(best: Carried, pool: Pool, one: Worth, tried: int) -> Carried:
    """Another effect in the window of the best."""
    (own,) = carried(pool, one, (best.window,), tried)
    return own


def spreads_most(around: Sequence[Carried]) -> Carried:
    """Of effects in one window the likeliest, with what it explains in other runs."""
    return max(around, key=lambda each: each.total)


def simplest(pool: Pool, around: Sequence[Carried]) -> Carried:
    """Of effects in one window the likeliest; of those that explain it as well as forms are known,
    that of fewest parameters.
    """
    rows, beside = rows_of(pool, around[0].window), spreads_most(around)
    explained = [(explains(pool, each, rows, beside), each) for each in around]
    top, likeliest = max(explained, key=lambda pair: pair[0])
    alike = as_likely_within(top + likeliest.price)
    close = [each for value, each in sorted(explained, key=lambda p: -p[0]) if value > top - alike]
    return min(close, key=lambda each: each.evidence.size + len(each.effect.term.at))


def is_of_a_spread(
    pool: Pool, one: Carried, worth: Sequence[Worth], tried: int, limit: float
) -> bool:
    """Whether chance makes what is left of a finding beside the spread between units of another
    effect, as the other runs show it: what all units have some of is no mismatch.

    tried, limit: how much was tried, and the corrected p value that is believed.
    """
    rows = rows_of(pool, one.window)
    for other in worth:
        spread = None if other.effect.name == one.effect.name else usual(other.evidence, rows)
        if spread is not None:
            gain = gain_beside(pool, one, other.effect, spread)
            if float(chdtrc(one.evidence.size, gain)) * tried > limit:
                return True
    return False


def with_the_same_runs(pool: Pool, every: Sequence[Carried], best: Carried) -> list[Carried]:
    """Effects in windows that have most of the best's runs, believed or not."""
    own = rows_of(pool, best.window)
    return [each for each in every if (rows_of(pool, each.window) & own).sum() > COMMON * own.sum()]


def other_names(
    pool: Pool, some: Sequence[Carried], best: Carried, beside: Carried
) -> tuple[Carried, ...]:
    """Other names that are as likely in the runs of both, the best of each.

    beside: as in `explains`.
    """
    own, found = rows_of(pool, best.window), dict[str, tuple[float, Carried]]()
    values = dict[bytes, float]()  # of the best, in the runs of both
    for each in some:
        if each.effect.name == best.effect.name:
            continue
        rows = own | rows_of(pool, each.window)
        if rows.tobytes() not in values:
            values[rows.tobytes()] = explains(pool, best, rows, beside)
        value = values[rows.tobytes()]
        far = value - explains(pool, each, rows, beside)
        far += price_of_more(best, each, int(own.sum())) - each.effect.unlikely
        alike = as_likely_within(value + best.price)
        if far < min(alike, found.get(each.effect.name, (np.inf, best))[0]):
            found[each.effect.name] = far, each
    return tuple(each for _, each in sorted(found.values(), key=lambda pair: pair[0]))


def other_carriers(
    some: Sequence[Carried], best: Carried, names: Sequence[Carried]
) -> tuple[Carried, ...]:
    """Where the effect, or one of the other names, is as likely: the first of each carrier."""
    found: dict[tuple[Level, int], Carried] = {}
    for each in some:
        same = each.effect == best.effect and each.total > best.total - CERTAIN
        if same or any(each is one for one in names):
            found.setdefault((each.window.level, each.window.carrier), each)
    found.pop((best.window.level, best.window.carrier), None)
    return tuple(found.values())


def price_of_more(best: Carried, other: Carried, runs: int) -> float:
    """Of what another has beyond the best that it holds, which fits it whatever it is: as `explain`
    counts it, the logarithm of the intervals for each parameter.
    """
    if HOLDS.get(best.effect.name) != other.effect.name:
        return 0.0
    more = max(0, other.evidence.size - best.evidence.size)
    return float(more * (np.log(INTERVALS * runs) - PER_PARAMETER))
