"""Tilts that no catalogued physics explains."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import GRAVITY, motion

from tasks.explain.search.empirical import empirical
from tasks.explain.search.empirical_terms import LostMotion, Tip, leans, lost_motion, tips
from tasks.model.term import Inputs
from tasks.motion.table import TableAxes

RUN = motion()


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
