"""What many runs show together, tried on fleets of statistics whose truth is known."""

import numpy as np
import pytest

from schemas.discrepancy import PooledTerm
from tasks.review.carriers import Carried, price_of_more
from tasks.review.hypotheses import Effect, Evidence, at_unit_information
from tasks.review.random_effects import spreads
from tasks.review.search import Found, search
from tasks.review.windows import Window
from tests.tasks.review.fleet import NOTHING, SIZES, fleet, of, place

IN_ONE_RUN = 2.0  # each parameter: z of about three


def carrier(found: Found) -> tuple[str, str, str]:
    window = found.best.window
    return found.best.effect.name, window.level, found.pool.names[window.level][window.carrier]


def test_what_no_run_shows_alone_is_found_at_its_station():
    pool = fleet(1, lambda unit, station, day: of("axis_tilt", IN_ONE_RUN * (station == 2)))
    found, p_value = search(pool)
    assert [carrier(one) for one in found] == [("axis_tilt", "station", "S2")]
    assert p_value < 1e-6
    assert found[0].values == pytest.approx([IN_ONE_RUN, IN_ONE_RUN], abs=0.8)


def test_a_model_and_a_single_unit_are_carriers_too():
    model = fleet(2, lambda unit, station, day: of("size_effect", IN_ONE_RUN * (unit % 2)))
    single = fleet(
        3, lambda unit, station, day: of("size_effect", IN_ONE_RUN * (unit == 4)), runs=120, units=8
    )  # fmt: skip
    assert [carrier(one) for one in search(model)[0]] == [("size_effect", "model", "M1")]
    assert [carrier(one) for one in search(single)[0]] == [("size_effect", "unit", "U4")]


def test_a_change_is_dated_within_its_interval():
    pool = fleet(4, lambda unit, station, day: of("axis_tilt", 1.5 * IN_ONE_RUN * (day >= 50)))
    (one,), _ = search(pool)
    assert carrier(one)[1:] == ("site", "here")
    assert one.since is not None
    assert one.until is None
    assert abs(one.since.run - 50) <= 2
    assert one.since.earliest <= 50 <= one.since.latest


def test_a_spread_between_units_is_no_mismatch():
    spread = np.random.default_rng(9).standard_normal((12, SIZES[2])) * IN_ONE_RUN

    def values(unit: int, station: int, day: int) -> np.ndarray:
        own = NOTHING.copy()
        own[place("size_effect")] = spread[unit]
        return own

    assert search(fleet(5, values))[0] == ()


ALIKE = ("size_effect", "gyro_g2_sensitivity")


def test_effects_that_the_runs_hardly_tell_apart_are_named_together():
    def at_a_station(unit: int, station: int, day: int) -> np.ndarray:
        return of("size_effect", IN_ONE_RUN * (station == 2))

    (apart,), (together,) = (search(fleet(12, at_a_station, alike=a))[0] for a in (None, ALIKE))
    assert {each.effect.name for each in apart.others} == set()
    assert {apart.best.effect.name} == {"size_effect"}
    named = {together.best.effect.name, *(each.effect.name for each in together.others)}
    assert named == set(ALIKE)


def test_two_effects_are_found_one_after_the_other():
    def values(unit: int, station: int, day: int) -> np.ndarray:
        tilted = of("axis_tilt", 2.0 * IN_ONE_RUN * (station == 1))
        return tilted + of("gyro_g2_sensitivity", IN_ONE_RUN * (unit % 2))

    names = {carrier(one) for one in search(fleet(6, values, runs=120))[0]}
    assert names == {("axis_tilt", "station", "S1"), ("gyro_g2_sensitivity", "model", "M1")}


def test_clean_fleets_raise_no_alarm():
    alarms = [search(fleet(100 + k, lambda unit, station, day: NOTHING))[0] for k in range(12)]
    assert [alarm for alarm in alarms if alarm] == []


def _carried(name: str, size: int) -> Carried:
    """An effect of so many numbers in three runs."""
    term = PooledTerm(name=name, family="f", at=(), rarity=0.0, known=False, parameters=())
    information = np.tile(np.eye(size), (3, 1, 1))
    evidence: Evidence = at_unit_information(np.ones((3, size)), information, np.arange(3))
    (spread,) = spreads(evidence, (0.0,), (0.0,))
    return Carried(Effect(term, ()), evidence, Window("unit", 0, 0, 3, 3), spread, 9.0, 9.0, 9.0, 0)


def test_what_holds_the_best_pays_for_each_number_more_the_more_runs_there_are():
    lever_arm, size_effect = _carried("lever_arm", 3), _carried("size_effect", 6)
    few, many = (price_of_more(lever_arm, size_effect, runs) for runs in (3, 30))
    assert many - few == pytest.approx(3 * np.log(10.0))
    assert few > 6.0
    assert price_of_more(size_effect, lever_arm, 30) == 0.0
    assert price_of_more(lever_arm, _carried("axis_tilt", 6), 30) == 0.0
