"""What a drive leaves behind, against states stepped row by row or known beforehand."""

import numpy as np
import pytest

from tasks.model.terms.hysteresis import faded, last_peak, last_sign, late_sign, relaxed, stopped

STEP = 0.01
T = np.arange(2000) * STEP
WAVES = 2.0 * np.sin(T) * (T < 15.0)
TURNS = np.concatenate([np.zeros(100), np.full(100, 2.0), np.zeros(200), np.full(50, -1.0)])
STILL = 1e-3


def stepped(rate: np.ndarray, angle: float) -> np.ndarray:
    state, found = 0.0, []
    for n, w in enumerate(rate):
        if n and abs(w) > STILL:
            state = np.sign(w) + (state - np.sign(w)) * np.exp(-abs(w) * STEP / angle)
        found.append(state)
    return np.array(found)


@pytest.mark.parametrize("angle", [0.03, 0.3])
def test_friction_goes_to_the_sign_of_the_motion_within_a_travel(angle):
    step = np.diff(T, prepend=0.0)
    assert relaxed(WAVES, step, angle, STILL) == pytest.approx(stepped(WAVES, angle), abs=1e-9)


def test_what_does_not_move_keeps_its_state_and_has_none_at_first():
    unknown = np.where(TURNS == 0.0, np.nan, TURNS)
    for state in (
        relaxed(unknown, np.full(len(TURNS), STEP), 0.1, STILL), last_sign(unknown, STILL),
        last_peak(unknown, STILL),
    ):  # fmt: skip
        assert not state[:100].any()
        assert state[399] == state[199] > 0.99
        assert state[-1] < 0.0


def test_the_sign_of_the_last_motion_is_forgotten_in_time():
    t = np.arange(len(TURNS)) * STEP
    state = faded(TURNS, t, 0.5, STILL)
    assert (state[100:200] == 1.0).all()
    assert state[300] == pytest.approx(np.exp(-101 * STEP / 0.5))
    assert (state[400:] == -1.0).all()


def test_a_late_sign_is_learnt_as_slowly_as_it_is_forgotten():
    t = np.arange(len(TURNS)) * STEP
    state = late_sign(TURNS, t, 0.5, STILL)
    assert state[199] == pytest.approx(1.0 - np.exp(-1.0 / 0.5), abs=1e-6)
    assert state[399] == pytest.approx(state[199] * np.exp(-2.0 / 0.5), abs=1e-6)


def test_the_fastest_of_the_last_motion_stays_until_the_next():
    state = last_peak(np.concatenate([[0.0, 1.0, 3.0, 2.0, 0.0, -1.0, 0.0], [-6.0, 0.0]]), STILL)
    assert state.tolist() == pytest.approx([0, 1 / 6, 0.5, 0.5, 0.5, -1 / 6, -1 / 6, -1, -1])


def test_a_drive_less_its_play_is_stopped_at_the_radius():
    drive = np.array([0.0, 1.0, 3.0, 2.0, np.nan, -1.0, -0.5])
    play = [0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0]  # of width 4: the flanks touch at 3 and at −1
    assert stopped(drive, 2.0) == pytest.approx(
        np.where(np.isnan(drive), 0.0, (np.nan_to_num(drive) - play) / 2.0)
    )


def test_a_stopped_drive_is_the_sum_that_is_clipped_row_by_row():
    drive = np.cumsum(np.random.default_rng(1).standard_normal(500))
    state, before, expected = 0.0, drive[0], []
    for value in drive:
        state = min(max(state + value - before, -3.0), 3.0)
        before = value
        expected.append(state / 3.0)
    assert stopped(drive, 3.0) == pytest.approx(expected, abs=1e-12)
