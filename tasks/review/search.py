"""Finds what the runs show together, one finding at a time until chance explains the rest."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from schemas.discrepancy import LEVELS
from tasks.explain.explanation import CERTAIN
from tasks.review.carriers import (
    Carried,
    Change,
    at_window_of,
    carried,
    chance,
    change_of,
    is_of_a_spread,
    likeliest,
    other_carriers,
    other_names,
    refined,
    simplest,
    spreads_most,
    tried_of,
    with_both_ends,
    with_the_same_runs,
)
from tasks.review.hypotheses import Effect, at_unit_information
from tasks.review.pool import Pool
from tasks.review.random_effects import BETWEEN_UNITS, Worth, promising, screened, spreads
from tasks.review.windows import LevelWindows, Window, WindowSums, all_windows, rows_of, window_sums

FALSE_ALARMS = 0.01
MOST_FINDINGS = 6


# Whether a unit stands out from the usual spread of an effect among units.
#
# The forms of one name (orders, time constants) look alike in a run: units that differ in one form
# of it make a unit that differs in another no mismatch.


@dataclass(frozen=True)
class OwnValues:
    """What the units of a pool have of their own; what was found of one form is kept."""

    pool: Pool
    found: dict[tuple[Effect, int], float] = field(default_factory=dict)

    def stands_out(self, one: Carried, tried: int, limit: float) -> bool:
        """Whether a unit's value is beyond the spread that the other units show in other forms.

        tried, limit: how much was tried, and the corrected p value that is believed.
        """
        if one.window.level != "unit":
            return True
        tau = max(
            (self._spread(effect, one.window.carrier) for effect in self._other_forms(one)),
            default=0.0,
        )
        if tau <= one.spread.tau:
            return True
        rows = rows_of(self.pool, one.window)[None]
        (spread,) = spreads(one.evidence, (one.spread.sigma,), (tau,))
        gain = 2.0 * float(spread.gains(rows)[0])
        return chance(one.evidence, spread, gain, rows[0]) * tried < limit

    def _other_forms(self, one: Carried) -> Iterator[Effect]:
        """Whole terms of the same name in another form."""
        for effect in self.pool.effects:
            whole = len(effect.own) == len(effect.term.parameters)
            if whole and effect.name == one.effect.name and effect.term.at != one.effect.term.at:
                yield effect

    def _spread(self, effect: Effect, unit: int) -> float:
        """The likeliest spread between the other units in one form."""
        if (effect, unit) not in self.found:
            self.found[effect, unit] = self._likeliest(effect, unit)
        return self.found[effect, unit]

    def _likeliest(self, effect: Effect, unit: int) -> float:
        others = self.pool.unit != unit
        score, information = self.pool.evidence(effect)
        evidence = at_unit_information(
            score * others[:, None], information * others[:, None, None], self.pool.unit
        )
        if not evidence.size:
            return 0.0
        return likeliest(evidence, (0.0,), BETWEEN_UNITS).tau


@dataclass(frozen=True)
class Found:
    """An effect that a carrier has.

    values: (m,) SI with their covariance. since, until: None where it was there from the carrier's
    first run, or to its last. pool: what the findings before it have left. carriers: the same
    effect elsewhere, as likely within CERTAIN, and other effects elsewhere that explain
    the same runs; others: names that are as likely.
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
    """The findings, and the p value of the first mismatch, corrected for all that is tried."""
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
    worth = promising(pool, looked)
    if not worth:
        return None, looked[0].p_value if looked else 1.0
    every = [each for one in worth for each in carried(pool, one, one.windows, tried)]
    believed = [each for each in every if _believed(each) and _plausible(pool, each)]
    if not believed:
        return None, max(min(each.p_value for each in every), FALSE_ALARMS)
    dismissed = set[Window]()
    for first in _standing_out(pool, believed, worth, tried):
        if first.window in dismissed:
            continue
        found = _found(pool, first, every, worth, tried)
        # Where the likeliest name is one that the units' spread explains there, nothing is there
        # that they do not have anyway.
        if _believed(found.best):
            return found, first.p_value
        dismissed.add(first.window)
    return None, FALSE_ALARMS


def _found(
    pool: Pool, first: Carried, every: Sequence[Carried], worth: Sequence[Worth], tried: int
) -> Found:
    """What a carrier has: the likeliest name, its carrier and the alternatives to both.

    first: the strongest mismatch. Whether an effect is believed by itself says nothing of whether
    it is what was found.
    """
    around = [at_window_of(first, pool, one, tried) for one in worth]
    around = [first, *(each for each in around if _plausible(pool, each))]
    name, beside = simplest(pool, around), spreads_most(around)
    alike = with_the_same_runs(pool, every, first)
    own = [_finer(pool, each, tried) for each in (name, *alike) if each.effect == name.effect]
    best = _smallest(pool, sorted(own, key=lambda each: -each.total))
    others = [each for each in (*around, *alike) if _plausible(pool, each)]
    names = other_names(pool, others, best, beside)
    values, covariance = best.values(pool)
    since, until = change_of(pool, best, "first"), change_of(pool, best, "last")
    return Found(
        best, values, covariance, since, until, pool,
        other_carriers([*own, *others], best, names), names,
    )  # fmt: skip


def _believed(one: Carried) -> bool:
    """Not by chance, of all that was tried; and against no effect as conclusive as one name is to
    be against another: a name costs its parameters and its rarity, which no p value counts.
    """
    return one.p_value < FALSE_ALARMS and one.score > CERTAIN


def _standing_out(
    pool: Pool, believed: Sequence[Carried], worth: Sequence[Worth], tried: int
) -> Iterator[Carried]:
    """What is believed that is not of the usual spread between units, about the best first."""
    own, rest = OwnValues(pool), sorted(believed, key=lambda each: -each.score)
    while rest:
        near = [each for each in rest if each.score > rest[0].score - 4.0 * CERTAIN]
        finer = [_finer(pool, each, tried) for each in near]
        for each in sorted(finer, key=lambda each: -each.score):
            if own.stands_out(each, tried, FALSE_ALARMS) and not is_of_a_spread(
                pool, each, worth, tried, FALSE_ALARMS
            ):
                yield each
        rest = rest[len(near) :]


def _finer(pool: Pool, one: Carried, tried: int) -> Carried:
    return with_both_ends(pool, refined(pool, one, tried), tried)


def _smallest(pool: Pool, finer: Sequence[Carried]) -> Carried:
    """The best; of carriers with the very same runs the one of the smallest level."""
    rows = rows_of(pool, finer[0].window)
    same = [
        each
        for each in finer
        if each.effect == finer[0].effect and (rows_of(pool, each.window) == rows).all()
    ]
    return min(same, key=lambda each: LEVELS.index(each.window.level))


def _plausible(pool: Pool, one: Carried) -> bool:
    """Every parameter within the plausible range of the effect."""
    values, covariance = one.values(pool)
    u = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    low = np.array([p.low for p in one.effect.parameters]) - 2.0 * u
    high = np.array([p.high for p in one.effect.parameters]) + 2.0 * u
    return bool(((values >= low) & (values <= high)).all())
