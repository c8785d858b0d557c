"""What the runs show together, one finding after the other until chance would show as much."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from schemas.review import LEVELS, Level
from tasks.explain.confounding.compare import HOLDS
from tasks.explain.search.scores import INDISTINGUISHABLE, PER_PARAMETER
from tasks.review.carriers import (
    Carried,
    Change,
    carried,
    change_of,
    refined,
    scored,
    tried_of,
    with_both_ends,
)
from tasks.review.mixed import spreads
from tasks.review.own_values import OwnValues
from tasks.review.pool import Pool
from tasks.review.screening import Worth, screened, worth_a_look
from tasks.review.sums import WindowSums, window_sums
from tasks.review.windows import LevelWindows, all_windows, rows_of

FALSE_ALARMS = 0.01
MOST_FINDINGS = 6
INTERVALS = 50  # of a run that show an effect
FORM = 0.1  # relative: how well the linear form of a strong effect is known


@dataclass(frozen=True)
class Found:
    """An effect that a carrier has.

    values: (m,) SI with their covariance. since, until: None where it was there from the carrier's
    first run, or to its last. pool: what the findings before it have left. carriers: the same
    effect elsewhere, as likely within INDISTINGUISHABLE; others: names likewise.
    """

    best: Carried
    values: np.ndarray
    covariance: np.ndarray
    since: Change | None
    until: Change | None
    pool: Pool
    carriers: tuple[Carried, ...]
    others: tuple[Carried, ...]


def search(pool: Pool) -> tuple[tuple[Found, ...], float]:
    """The findings, and the p value of the strongest mismatch, corrected for all that is tried."""
    found, p_value = list[Found](), 1.0
    levels = all_windows(pool)
    sums = window_sums(pool, levels)
    while len(found) < MOST_FINDINGS:
        one, strongest = _next(pool, levels, sums)
        if not found:
            p_value = strongest
        if one is None:
            break
        found.append(one)
        pool = pool.less(one.best.effect, one.values, rows_of(pool, one.best.window))
    return tuple(found), p_value


def _next(
    pool: Pool, levels: Sequence[LevelWindows], sums: WindowSums
) -> tuple[Found | None, float]:
    tried = tried_of(pool, [level.windows for level in levels])
    looked = screened(pool, levels, sums, tried)
    worth = worth_a_look(pool, looked)
    if not worth:
        return None, looked[0].p_value if looked else 1.0
    every = [each for one in worth for each in carried(pool, one, tried)]
    believed = [each for each in every if each.p_value < FALSE_ALARMS and _plausible(pool, each)]
    if not believed:
        return None, max(min(each.p_value for each in every), FALSE_ALARMS)
    leading = sorted(believed, key=lambda each: -each.score)
    own = OwnValues(pool)
    leading = [each for each in leading if own.stands_out(each, tried, FALSE_ALARMS)]
    if not leading:
        return None, FALSE_ALARMS
    near = [each for each in leading if each.score > leading[0].score - 4.0 * INDISTINGUISHABLE]
    finer = sorted(
        (with_both_ends(pool, refined(pool, each, tried), tried) for each in near),
        key=lambda each: -each.score,
    )
    best = _smallest(pool, finer)
    carriers = _carriers(finer, best)
    alike = max(INDISTINGUISHABLE, FORM**2 * best.gain)
    # Beside one spread: each effect's own may make its score larger than its name deserves.
    strong, believable = alike > INDISTINGUISHABLE, {each.effect for each in leading}
    around = [
        best,
        *(
            _at_window_of(best, pool, one, tried)
            for one in worth
            if strong or one.effect in believable or HOLDS.get(one.effect.name) == best.effect.name
        ),
    ]
    if strong:
        best = _simplest(around, alike)
    values, covariance = best.values(pool)
    since, until = change_of(pool, best, "first"), change_of(pool, best, "last")
    return (
        Found(
            best, values, covariance, since, until, pool, carriers,
            _names(around, best, alike, int(rows_of(pool, best.window).sum())),
        ),
        best.p_value,
    )  # fmt: skip


def _at_window_of(best: Carried, pool: Pool, one: Worth, tried: int) -> Carried:
    """Another effect in the window of the best, beside the same spread."""
    rows = rows_of(pool, best.window)
    sigma, tau = best.spread.sigma, best.spread.tau
    spread, _ = next(iter(spreads(one.evidence, (sigma,), (tau,), rows[None])))
    gain = 2.0 * float(spread.gains(rows[None])[0])
    return scored(pool, one.effect, one.evidence, best.window, spread, gain, gain, tried)


def _simplest(around: Sequence[Carried], alike: float) -> Carried:
    """Of strong effects whose scores differ by less than their linear forms are known, that of
    fewest parameters.
    """
    top = max(each.score for each in around)
    close = sorted((e for e in around if e.score > top - alike), key=lambda each: -each.score)
    return min(close, key=lambda each: each.evidence.size + len(each.effect.term.at))


def _smallest(pool: Pool, finer: Sequence[Carried]) -> Carried:
    """The best; of carriers with the very same runs the one of the smallest level."""
    rows = rows_of(pool, finer[0].window)
    same = [
        each
        for each in finer
        if each.effect == finer[0].effect and (rows_of(pool, each.window) == rows).all()
    ]
    return min(same, key=lambda each: LEVELS.index(each.window.level))


def _carriers(finer: Sequence[Carried], best: Carried) -> tuple[Carried, ...]:
    """Other carriers of the same effect that are as likely, the best window of each."""
    found: dict[tuple[Level, int], Carried] = {}
    for each in finer:
        if each.effect == best.effect and each.score > best.score - INDISTINGUISHABLE:
            found.setdefault((each.window.level, each.window.carrier), each)
    found.pop((best.window.level, best.window.carrier), None)
    return tuple(found.values())


def _names(finer: Sequence[Carried], best: Carried, alike: float, runs: int) -> tuple[Carried, ...]:
    """Other names that are as likely, the best of each; runs: in which the best is."""
    found: dict[str, Carried] = {}
    for each in finer:
        far = best.score - each.score + price_of_more(best, each, runs)
        if each.effect.name != best.effect.name and far < alike:
            found.setdefault(each.effect.name, each)
    return tuple(found.values())


def price_of_more(best: Carried, other: Carried, runs: int) -> float:
    """Of what another has beyond the best that it holds, which fits it whatever it is: as `explain`
    counts it, the logarithm of the intervals for each parameter.
    """
    if HOLDS.get(best.effect.name) != other.effect.name:
        return 0.0
    more = max(0, other.evidence.size - best.evidence.size)
    return float(more * (np.log(INTERVALS * runs) - PER_PARAMETER))


def _plausible(pool: Pool, one: Carried) -> bool:
    """Every parameter within the plausible range of the effect."""
    values, covariance = one.values(pool)
    u = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    low = np.array([p.low for p in one.effect.parameters]) - 2.0 * u
    high = np.array([p.high for p in one.effect.parameters]) + 2.0 * u
    return bool(((values >= low) & (values <= high)).all())
