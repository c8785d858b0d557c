"""What else explains the runs of a finding."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.explain.odds import CERTAIN
from tasks.review.carriers import Carried, carried, scored
from tasks.review.evidence import at_unit_information
from tasks.review.hypotheses import Effect
from tasks.review.pool import Pool
from tasks.review.random_effects import spreads
from tasks.review.rivals import is_of_a_spread, other_names
from tasks.review.screening import Worth
from tasks.review.windows import Window, rows_of
from tests.tasks.review.fleet import NOTHING, SIZES, fleet, of, place

UNIT = 4
TRIED = 10_000
ALIKE = ("size_effect", "gyro_g2_sensitivity")
OWN = 2.0 * np.random.default_rng(13).standard_normal((12, SIZES[3]))


def with_spread(spread: float) -> Pool:
    """Each unit has something of its own of one effect, and one of them more."""

    def values(unit: int, station: int, day: int) -> np.ndarray:
        own = NOTHING.copy()
        own[place(ALIKE[1])] = spread * OWN[unit]
        return own + of(ALIKE[1], 3.0 * (unit == UNIT))

    return fleet(13, values, runs=160, alike=ALIKE)


def worth(pool: Pool, name: str) -> Worth:
    whole = (each for each in pool.effects if each.name == name)
    effect: Effect = max(whole, key=lambda each: len(each.own))
    return Worth(effect, (), at_unit_information(*pool.evidence(effect), pool.unit))


def at_the_unit(pool: Pool, one: Worth) -> Carried:
    """The effect at the unit, as if units had no spread of it."""
    carrier = pool.names["unit"].index(f"U{UNIT}")
    count = int((pool.unit == carrier).sum())
    window = Window("unit", carrier, 0, count, count)
    rows = rows_of(pool, window)[None]
    (spread,) = spreads(one.evidence, (0.0,), (0.0,))
    gain = 2.0 * float(spread.gains(rows)[0])
    return scored(pool, one.effect, one.evidence, window, spread, gain, gain, 1)


@pytest.mark.parametrize(("spread", "is_usual"), [(1.0, True), (0.0, False)])
def test_a_unit_is_no_mismatch_by_what_all_have_of_an_effect_that_explains_it_as_well(
    spread: float, is_usual: bool
) -> None:
    pool = with_spread(spread)
    one = at_the_unit(pool, worth(pool, ALIKE[0]))
    assert one.score > 20.0
    assert is_of_a_spread(pool, one, [worth(pool, ALIKE[1])], TRIED, 0.01) == is_usual


def test_a_name_is_not_excluded_for_what_it_costs_beforehand() -> None:
    pool = fleet(
        12, lambda unit, station, day: of(ALIKE[0], 2.0 * (station == 2)), runs=80, alike=ALIKE
    )
    count = int((pool.carrier["station"] == 2).sum())
    windows = (Window("station", 2, 0, count, count),)
    best, alike = (replace(worth(pool, name), windows=windows) for name in ALIKE)
    many = replace(alike, effect=replace(alike.effect, trials=1000))
    (one,), others = (
        carried(pool, best, best.windows, TRIED),
        [carried(pool, each, each.windows, TRIED)[0] for each in (alike, many)],
    )
    assert others[0].score - others[1].score > CERTAIN
    for other in others:
        (named,) = other_names(pool, [other], one, one)
        assert named is other
