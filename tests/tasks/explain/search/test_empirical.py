"""What a mismatch may follow that no catalogued physics explains."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from engine_run import GRAVITY, MOVE, REST, SPANS, motion

from tasks.explain.explanation import GYROS, UNNAMED
from tasks.explain.search.empirical import (
    LostMotion,
    Tip,
    empirical,
    gravity_turns,
    lagged,
    leans,
    lost_motion,
    repositioning,
    scale_factor_drift,
    sinusoid,
    time_since,
    tips,
    turning,
)
from tasks.model.term import Inputs, Term
from tasks.motion.table import TableAxes
from tasks.words import LANGUAGES, texts

RUN = motion()
INPUTS = Inputs(RUN.rate, RUN.force)


def title(term: Term) -> Mapping[str, str]:
    return texts(term.title)


def test_everything_empirical_is_unnamed_and_says_in_two_languages_what_it_follows() -> None:
    terms = empirical(RUN)
    assert {term.name for term in terms} == {UNNAMED}
    titles = [title(term) for term in terms if not term.shapes]
    assert all(all(both.values()) for both in titles)
    for language in LANGUAGES:
        assert len({both[language] for both in titles}) == len(titles)


def test_every_empirical_term_has_a_finite_column_for_each_parameter() -> None:
    for term in (one for one in empirical(RUN) if one.stage == "sensor"):
        columns = term.columns(RUN, INPUTS)
        assert len(columns) == len(term.parameters)
        for column, parameter in zip(columns, term.parameters, strict=True):
            (channel,) = column
            sensor, axis = parameter.name.split("_")[:2]
            assert channel == 3 * (sensor == "accel") + "xyz".index(axis)
            assert np.isfinite(column[channel]).all()


POWERS = {  # of rates and of forces in a regressor, by its unit
    "rad/s": (1, 0), "(rad/s)^2": (2, 0), "(rad/s)^4": (4, 0), "rad/s^2": (1, 0),
    "m/s2": (0, 1), "(m/s2)^2": (0, 2),
}  # fmt: skip


def test_a_factor_has_the_unit_of_the_reading_over_that_of_what_it_follows() -> None:
    faster = replace(RUN, acceleration=2.0 * RUN.acceleration)
    doubled = Inputs(2.0 * RUN.rate, 3.0 * RUN.force)  # rates twice, forces three times as large
    units = set[str]()
    for term in (one for one in empirical(RUN) if one.stage == "sensor" and not one.shapes):
        pairs = zip(term.columns(RUN, INPUTS), term.columns(faster, doubled), strict=True)
        for parameter, (plain, larger) in zip(term.parameters, pairs, strict=True):
            (channel,) = plain
            own = "rad/s" if channel in GYROS else "m/s2"
            under = own if parameter.unit == "1" else parameter.unit.removeprefix(f"({own})/")
            if parameter.unit == own:
                rates, forces = 0, 0
            else:
                rates, forces = POWERS.get(under) or POWERS[under.strip("()")]
            factor = 2.0**rates * 3.0**forces
            np.testing.assert_allclose(larger[channel], factor * plain[channel], atol=1e-9)
            units.add(under)
    assert units >= POWERS.keys() - {"rad/s", "m/s2", "rad/s^2"}


def test_a_relaxation_begins_anew_when_a_move_is_over() -> None:
    since = time_since(RUN, turning(RUN))
    first_stop = REST + MOVE
    assert np.isinf(since[RUN.t < first_stop - 0.5]).all()
    middle = (RUN.t > first_stop) & (RUN.t % (REST + MOVE) < REST)
    expected = RUN.t[middle] % (REST + MOVE)
    assert np.abs(since[middle] - expected).max() < 0.3


def test_a_turn_about_the_vertical_does_not_change_gravitys_direction() -> None:
    level = np.tile([0.0, 0.0, 1.0], (len(RUN.t), 1))
    spun = replace(RUN, up=level)
    assert not gravity_turns(spun).any()
    assert gravity_turns(RUN).any()
    assert (
        gravity_turns(RUN) <= turning(RUN) | (np.gradient(RUN.up, axis=0) != 0).any(axis=1)
    ).all()


def test_a_run_at_constant_rate_is_not_a_move_to_another_position() -> None:
    moves = repositioning(RUN)
    assert (moves == turning(RUN)).all()
    steady = np.zeros(len(RUN.t))
    steady[(RUN.t > 33.0) & (RUN.t < 39.0)] = 1.0  # the second move is one
    recorded = dict(RUN.recorded, steady_turn=steady)
    some = repositioning(replace(RUN, recorded=recorded))
    assert not some[(RUN.t > 32.0) & (RUN.t < 40.0)].any()
    starts = np.flatnonzero(np.diff(some.astype(int)) == 1)
    assert len(starts) == SPANS - 1


@pytest.mark.parametrize("tau", [3.0, 45.0])
def test_a_lag_goes_to_its_course_with_its_time_constant(tau: float) -> None:
    t = np.arange(0.0, 200.0, 0.04)
    answer = lagged(np.ones_like(t), t, tau)
    np.testing.assert_allclose(answer, 1.0 - np.exp(-(t + 0.04) / tau), atol=1e-9)


def test_a_wave_has_any_phase_in_each_of_its_channels() -> None:
    term = sinusoid(GYROS).shaped((37.0,))
    columns = term.columns(RUN, INPUTS)
    assert [next(iter(column)) for column in columns] == [0, 0, 1, 1, 2, 2]
    made = np.sin(2.0 * np.pi * RUN.t / 37.0 + 0.7)
    pair = np.column_stack([columns[2][1], columns[3][1]])
    values, *_ = np.linalg.lstsq(pair, made, rcond=None)
    np.testing.assert_allclose(pair @ values, made, atol=1e-9)
    assert all("37 s" in text for text in title(term).values())


def test_a_scale_factor_drift_is_the_channels_own_input_times_slow_waves() -> None:
    columns = scale_factor_drift(30).columns(RUN, INPUTS)
    made = RUN.rate[:, 1] * np.sin(2.0 * np.pi * (RUN.t - 40.0) / (0.37 * RUN.t[-1]))
    own = np.column_stack([column[1] for column in columns if 1 in column] + [RUN.rate[:, 1]])
    values, *_ = np.linalg.lstsq(own, made, rcond=None)
    left = made - own @ values
    assert np.sqrt(np.mean(left**2)) < 0.02 * np.sqrt(np.mean(made**2))


def with_table(turned: float) -> tuple:
    angle = np.linspace(0.0, turned, len(RUN.t))[:, None]
    spins = np.tile([0.0, 0.0, 1.0], (len(RUN.t), 1, 1))
    axes = TableAxes(angle, np.zeros_like(angle), spins, RUN.north)
    return empirical(replace(RUN, axes=axes))


def test_harmonics_of_an_axis_are_asked_only_where_it_went_round() -> None:
    plain = {title(term)["en"] for term in empirical(RUN)}
    assert {title(term)["en"] for term in with_table(0.9 * 2.0 * np.pi)} == plain
    more = {title(term)["en"] for term in with_table(3.0 * 2.0 * np.pi)} - plain
    assert len(more) == 6 + 12
    assert all("table axis 1" in text for text in more)


# Tilts that no catalogued physics explains.


def test_a_lean_turns_gravity_near_its_angle_and_keeps_its_size() -> None:
    lean = list(leans(0))[5]
    angle = np.linspace(0.0, 6.0 * np.pi, len(RUN.t))[:, None]
    spins = np.tile([0.0, 0.0, 1.0], (len(RUN.t), 1, 1))
    run = replace(RUN, axes=TableAxes(angle, 0 * angle, spins, RUN.north))
    moved = lean.moved(run, np.array([1e-3, 0.0, 0.0]))
    np.testing.assert_allclose(np.linalg.norm(moved.force, axis=1), GRAVITY, rtol=2e-6)
    turned = np.linalg.norm(moved.up - run.up, axis=1)
    centre = np.radians(float(lean.equation.split("= ")[1].rstrip("°")))
    far = np.cos(angle[:, 0] - centre) < 0.0
    assert turned[far].max() < 0.02 * turned.max()
    assert turned.max() == pytest.approx(1e-3, rel=0.05)


def test_the_columns_of_a_lean_are_what_an_ideal_unit_reads_of_a_small_one() -> None:
    lean = list(leans(0))[5]
    angle = np.linspace(0.0, 6.0 * np.pi, len(RUN.t))[:, None]
    spins = np.tile([0.0, 0.0, 1.0], (len(RUN.t), 1, 1))
    run = replace(RUN, axes=TableAxes(angle, 0 * angle, spins, RUN.north))
    before = np.hstack([run.rate, run.force])
    for axis, column in enumerate(lean.columns(run, Inputs.of(run))):
        moved = lean.moved(run, 1e-4 * np.eye(3)[axis])
        change = (np.hstack([moved.rate, moved.force]) - before) / 1e-4
        for channel in range(6):
            read = column.get(channel, np.zeros(len(run.t)))
            np.testing.assert_allclose(read, change[:, channel], atol=1e-8)


def test_a_tip_is_one_angle_to_either_side() -> None:
    """By plain algebra: φ to one side where gravity's component is up, −φ where it is down."""
    angle = np.array([1e-3, 0.0, 0.0])
    moved = Tip.along(np.array([0.0, 0.0, 5.0])).moved(RUN, angle)
    side = np.sign(RUN.up[:, 2:])
    clear = np.abs(RUN.up[:, 2]) > 0.4
    turned = -side * np.cross(angle, RUN.up)
    np.testing.assert_allclose((moved.up - RUN.up)[clear], turned[clear], atol=2e-6)
    np.testing.assert_allclose(
        (moved.rate - RUN.rate)[clear], (-side * np.cross(angle, RUN.rate))[clear], atol=2e-6
    )


def test_tips_go_along_every_diagonal_once() -> None:
    directions = np.array([one.direction for one in tips()])
    np.testing.assert_allclose(np.abs(directions), 1.0 / np.sqrt(3.0))
    cosines = np.abs(directions @ directions.T)
    np.testing.assert_allclose(cosines[~np.eye(4, dtype=bool)], 1.0 / 3.0)
    assert len({one.own_title for one in tips()}) == 4


def test_lost_motion_lags_by_one_angle_behind_either_way() -> None:
    """A turntable there and back: by plain algebra up is where the lagging angle has it."""
    turn, level = 0.5 * np.sin(0.2 * RUN.t), np.tile([0.0, 0.0, 1.0], (len(RUN.t), 1))
    speed = 0.1 * np.cos(0.2 * RUN.t)
    north = np.column_stack([np.sin(turn), np.cos(turn), 0.0 * turn])
    axes = TableAxes(turn[:, None], speed[:, None], level[:, None], north)
    run = replace(RUN, up=level, north=north, rate=speed[:, None] * level, axes=axes)
    moved = lost_motion(0).moved(run, np.array([2e-3]))
    late = turn - 2e-3 * np.sign(speed)
    expected = np.column_stack([np.sin(late), np.cos(late), 0.0 * late])
    turning = np.abs(speed) > 0.01
    np.testing.assert_allclose(moved.north[turning], expected[turning], atol=3e-6)
    np.testing.assert_allclose(moved.rate, run.rate)


@pytest.mark.parametrize(("there_and_back", "asked"), [(True, True), (False, False)])
def test_lost_motion_shows_only_where_an_axis_turned_both_ways(
    there_and_back: bool, asked: bool
) -> None:
    speed = np.where(RUN.t < 30.0, 0.1, -0.1 if there_and_back else 0.1)[:, None]
    axes = TableAxes(np.cumsum(speed, axis=0) / 25.0, speed, RUN.up[:, None], RUN.north)
    terms = empirical(replace(RUN, axes=axes))
    assert any(isinstance(term, LostMotion) for term in terms) == asked
