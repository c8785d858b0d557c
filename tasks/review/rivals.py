"""Alternative explanations of a finding: other effects and other carriers."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from schemas.review import Level
from tasks.explain.confounding.special_case import HOLDS
from tasks.explain.search.scores import INDISTINGUISHABLE, PER_PARAMETER
from tasks.review.carriers import Carried, carried, scored
from tasks.review.mixed import Spread, spreads
from tasks.review.pool import Pool
from tasks.review.screening import Worth
from tasks.review.windows import Window, rows_of

WRONG_NAMES = 0.01
# Of score. Data of one model favour another by a likelihood ratio k with a probability of 1/k at
# most (Royall, Statistical Evidence, 1997, section 1.4): by so much to name one alone.
CONCLUSIVE = 2.0 * float(np.log(1.0 / WRONG_NAMES))
COMMON = 0.5  # of the runs of a finding: another that has them explains the same readings
INTERVALS = 50  # of a run that show an effect


def at_window_of(best: Carried, pool: Pool, one: Worth, tried: int) -> Carried:
    """Another effect in the window of the best: beside the same spread, or beside its own where it
    gains less there. Its own may make its score larger than its name deserves, and without its own
    it takes a spread between units for a value of one.
    """
    alike = _beside(best.spread, pool, one, best.window, tried)
    (own,) = carried(pool, replace(one, windows=(best.window,)), tried)
    return min(alike, own, key=lambda each: each.score)


def _beside(beside: Spread, pool: Pool, one: Worth, window: Window, tried: int) -> Carried:
    """An effect in a window beside a spread between runs and units like that of another."""
    rows = rows_of(pool, window)[None]
    spread, _ = next(iter(spreads(one.evidence, (beside.sigma,), (beside.tau,), rows)))
    gain = 2.0 * float(spread.gains(rows)[0])
    return scored(pool, one.effect, one.evidence, window, spread, gain, gain, tried)


def simplest(around: Sequence[Carried], alike: float) -> Carried:
    """Of strong effects whose scores differ by less than their linear forms are known, that of
    fewest parameters.
    """
    top = max(each.score for each in around)
    close = sorted((e for e in around if e.score > top - alike), key=lambda each: -each.score)
    return min(close, key=lambda each: each.evidence.size + len(each.effect.term.at))


def is_of_a_spread(pool: Pool, one: Carried, worth: Sequence[Worth], tried: int) -> bool:
    """Whether what a unit seems to have is explained as well by another effect of which all units
    have some of their own, as units do.
    """
    if one.window.level != "unit":
        return False
    for other in worth:
        if other.effect.name == one.effect.name:
            continue
        (own,) = carried(pool, replace(other, windows=(one.window,)), tried)
        if own.spread.tau > one.spread.tau:
            alone = _beside(one.spread, pool, other, one.window, tried)
            if alone.score > one.score - CONCLUSIVE:
                return True
    return False


def with_the_same_runs(pool: Pool, every: Sequence[Carried], best: Carried) -> list[Carried]:
    """Other effects in windows that have most of the best's runs, believed or not."""
    own = rows_of(pool, best.window)
    some = [
        each
        for each in every
        if each.effect.name != best.effect.name
        and (rows_of(pool, each.window) & own).sum() > COMMON * own.sum()
    ]
    return sorted(some, key=lambda each: -each.score)


def other_names(
    some: Sequence[Carried], best: Carried, alike: float, rows: np.ndarray
) -> tuple[Carried, ...]:
    """Other names that are as likely, the best of each; rows: (runs,) bool, of the best."""
    found: dict[str, Carried] = {}
    for each in some:
        far = best.score - each.score + price_of_more(best, each, int(rows.sum()))
        if each.effect.name != best.effect.name and far < alike:
            found.setdefault(each.effect.name, each)
    return tuple(found.values())


def other_carriers(
    some: Sequence[Carried], best: Carried, names: Sequence[Carried]
) -> tuple[Carried, ...]:
    """Where the effect, or one of the other names, is as likely: the first of each carrier."""
    found: dict[tuple[Level, int], Carried] = {}
    for each in some:
        same = each.effect == best.effect and each.score > best.score - INDISTINGUISHABLE
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
