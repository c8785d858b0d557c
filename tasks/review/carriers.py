"""Which carrier has an effect, against a spread between units and runs that looks the same."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, fdtrc

from schemas.discrepancy import Level
from tasks.explain.explanation import CERTAIN, as_likely_within
from tasks.explain.search.stepwise import HOLDS, PER_PARAMETER
from tasks.review.hypotheses import Effect, Evidence, ridged, solved
from tasks.review.pool import Pool
from tasks.review.random_effects import BETWEEN_UNITS, Spread, Worth, gains_of_each, spreads
from tasks.review.windows import Window, rows_of, runs_of

PER_CHANGE = 4.0
RARE = 1e-3  # chance that nothing is believed of, however well a spread is known


@dataclass(frozen=True)
class Carried:
    """An effect in a window of runs, with the spread that explains the rest best.

    gain: chi-squared that the common value takes away beside that spread. score: gain less its
    price. beyond: twice the nats beyond the likeliest spread without a common value, which is the
    test; p_value: of that, corrected for all that was tried.
    """

    effect: Effect
    evidence: Evidence
    window: Window
    spread: Spread
    gain: float
    beyond: float
    score: float
    p_value: float

    @property
    def price(self) -> float:
        return self.gain - self.score

    @property
    def total(self) -> float:
        """Twice the nats of the common value and its spread against neither, less the price.

        Of one effect's windows, each beside a spread of its own, the likeliest has the greatest;
        `gain` depends on how much the spread has taken before.
        """
        return 2.0 * self.spread.likelihood + self.score

    def values(self, pool: Pool) -> tuple[np.ndarray, np.ndarray]:
        """(m,) values and (m, m) covariance, SI."""
        right, information = self.spread.common(rows_of(pool, self.window))
        back = self.evidence.back
        covariance = back @ np.linalg.pinv(information, hermitian=True) @ back.T
        return back @ solved(information, right), covariance


def carried(pool: Pool, one: Worth, windows: Sequence[Window], tried: int) -> list[Carried]:
    """An effect in each of some windows, the best first; tried: windows and effects in all."""
    rows = np.array([rows_of(pool, window) for window in windows])
    looked = list(gains_of_each(one.spreads, rows))
    nothing = max(spread.likelihood for spread, _ in looked)
    likelihoods = np.array([spread.likelihood + gains for spread, gains in looked])
    found = []
    for number, (window, k) in enumerate(zip(windows, likelihoods.argmax(axis=0), strict=True)):
        spread, gains = looked[int(k)]
        beyond = spread.likelihood + gains[number] - nothing
        found.append(
            scored(pool, one.effect, one.evidence, window, spread, 2.0 * float(gains[number]),
                   2.0 * float(beyond), tried)
        )  # fmt: skip
    return sorted(found, key=lambda each: -each.score)


def scored(
    pool: Pool,
    effect: Effect,
    evidence: Evidence,
    window: Window,
    spread: Spread,
    gain: float,
    beyond: float,
    tried: int,
) -> Carried:
    """With the price: of its parameters, of how many of its name and level there are, and of each
    change the number of runs at which it may be."""
    price = PER_PARAMETER * (evidence.size + len(effect.term.at))  # a shape is searched for, too
    price += effect.unlikely
    price += 2.0 * np.log(max(1, len(pool.names[window.level])))
    price += window.changes * (PER_CHANGE + 2.0 * np.log(window.count))
    # What is known to be there needs no other that imitates it.
    price -= CERTAIN if effect.term.known and gain > 2.0 * CERTAIN else 0.0
    p_value = min(1.0, chance(evidence, spread, beyond, rows_of(pool, window)) * tried)
    return Carried(effect, evidence, window, spread, gain, beyond, gain - price, p_value)


def chance(evidence: Evidence, spread: Spread, beyond: float, rows: np.ndarray) -> float:
    """That chance shows as much in some runs (runs,) bool."""
    if beyond <= 0.0:
        return 1.0
    known = float(chdtrc(evidence.size, beyond))
    if not spread.tau or evidence.units < 2 or known > RARE:
        return known
    freedom = _freedom(evidence, spread, rows)
    return float(fdtrc(evidence.size, freedom, beyond / evidence.size))


def _freedom(evidence: Evidence, spread: Spread, rows: np.ndarray) -> float:
    """Degrees of freedom of the variance of a common value: that between units is known as few of
    them let it be known, that within runs is (Satterthwaite, Biometrics Bulletin 2, 1946).
    """
    (alone,) = spreads(evidence, (spread.sigma,), (0.0,))
    within, both = (each.common(rows)[1] for each in (alone, spread))
    left = float(np.trace(np.linalg.solve(ridged(within), both))) / evidence.size
    share = min(1.0, max(1.0 - left, 1e-3))  # of the variance, between units
    return (evidence.units - 1.0) / share**2


@dataclass(frozen=True)
class Change:
    """A carrier's run from which on, or up to which, and the first and last that it may be.

    without: its run before the first of a beginning, after the last of an end.
    """

    run: int
    earliest: int
    latest: int
    without: int


def refined(pool: Pool, one: Carried, tried: int) -> Carried:
    """Moves the first and last run to the likeliest ones."""
    for _ in range(2):
        for side in ("first", "last"):
            if getattr(one.window, side) not in (0, one.window.count):
                one = _at_best(pool, one, side, tried)
    return one


def with_both_ends(pool: Pool, one: Carried, tried: int) -> Carried:
    """Adds a second change where it gains more than its price."""
    best = one
    for side in ("first", "last"):
        if getattr(one.window, side) in (0, one.window.count):
            other = _at_best(pool, one, side, tried)
            best = max(best, other, key=lambda each: each.score)
    return best


def _at_best(pool: Pool, one: Carried, side: str, tried: int) -> Carried:
    """With the first or last run at which a common value gains most."""
    gains = profile(pool, one, side)
    if not gains:
        return one
    at = max(gains, key=lambda k: gains[k])
    more = 2.0 * gains[at] - one.gain
    return scored(
        pool, one.effect, one.evidence, moved(one.window, side, at), one.spread, one.gain + more,
        one.beyond + more, tried,
    )  # fmt: skip


def moved(window: Window, side: str, at: int) -> Window:
    """The window with another first or last run."""
    ends = {"first": window.first, "last": window.last} | {side: at}
    return Window(window.level, window.carrier, ends["first"], ends["last"], window.count)


def profile(pool: Pool, one: Carried, side: str) -> dict[int, float]:
    """Nats gained with every other first (or last) run of the window, at the best values."""
    window = one.window
    own = runs_of(pool, window.level, window.carrier)
    if side == "first":
        gains = one.spread.nested_gains(own[: window.last][::-1])[::-1]
        return dict(enumerate(gains[1:].tolist(), start=1))
    gains = one.spread.nested_gains(own[window.first :])
    return dict(enumerate(gains[:-1].tolist(), start=window.first + 1))


CONFIDENT = 1.92  # nats: half of the 95 % point of chi-squared with one degree of freedom


def change_of(pool: Pool, one: Carried, side: str) -> Change | None:
    """The change at one end of the window; None where it is that of the carrier's runs."""
    at = getattr(one.window, side)
    if at in (0, one.window.count):
        return None
    gains = profile(pool, one, side)
    likely = [k for k, gain in gains.items() if gain > max(gains.values()) - CONFIDENT]
    own = runs_of(pool, one.window.level, one.window.carrier)
    last = side == "last"  # of a window that ends before run `at`
    without = max(likely) + 1 if last else min(likely) - 1
    return Change(*(int(own[k - last]) for k in (at, min(likely), max(likely), without)))


def tried_of(pool: Pool, windows: Sequence[Sequence[Window]]) -> int:
    """How many effects in how many windows were tried."""
    return len(pool.effects) * sum(len(some) for some in windows)


# By how much effects explain the same runs: what names are compared by.


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


# Alternative explanations of a finding: other effects and other carriers.

COMMON = 0.5  # of the runs of a finding: another that has them explains the same readings
INTERVALS = 50  # of a run that show an effect


def at_window_of(best: Carried, pool: Pool, one: Worth, tried: int) -> Carried:
    """Another effect in the window of the best."""
    (own,) = carried(pool, one, (best.window,), tried)
    return own


def spreads_most(around: Sequence[Carried]) -> Carried:
    """Picks the likeliest effect of one window, with what it explains in other runs."""
    return max(around, key=lambda each: each.total)


def simplest(pool: Pool, around: Sequence[Carried]) -> Carried:
    """Picks the likeliest effect of one window; of those that explain it as well as forms are
    known, that of fewest parameters.
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
    """Prices what another has beyond the best that it holds, which fits it whatever it is: as
    `explain` counts it, the logarithm of the intervals for each parameter.
    """
    if HOLDS.get(best.effect.name) != other.effect.name:
        return 0.0
    more = max(0, other.evidence.size - best.evidence.size)
    return float(more * (np.log(INTERVALS * runs) - PER_PARAMETER))
