"""What a unit remembers, against the state stepped row by row."""

from dataclasses import replace

import numpy as np
import pytest
from table_run import T, motion, read, recording

from tasks.model.terms.memory import BIAS_RANDOM_WALK, bias_step, candidates, hysteresis, last_turn

RUN = motion()


def stepped(rate: np.ndarray, step: float, angle: float) -> np.ndarray:
    state, found = 0.0, []
    for n, w in enumerate(rate):
        if n and abs(w) > 1e-3:
            fade = np.exp(-abs(w) * step / angle)
            state = np.sign(w) + (state - np.sign(w)) * fade
        found.append(state)
    return np.array(found)


@pytest.mark.parametrize("angle", [0.03, 0.3])
def test_the_state_goes_to_the_sign_of_the_turn_within_an_angle(angle: float) -> None:
    step = float(T[1] - T[0])
    change = read((hysteresis(angle),), [1e-3, 2e-3, -3e-3]) - read((), [])
    states = np.column_stack([stepped(rate, step, angle) for rate in RUN.rate.T])
    assert change[:, :3] == pytest.approx(states * [1e-3, 2e-3, -3e-3], abs=1e-9)
    assert not change[:, 3:].any()


def test_at_rest_the_state_stays_and_before_any_turn_it_is_zero() -> None:
    rate = np.concatenate([np.zeros(50), np.full(100, 1.0), np.full(50, 5e-4), np.full(9, -1.0)])
    state = last_turn(rate, np.full(len(rate), 0.01), 0.1)
    assert not state[:50].any()
    assert state[149] == pytest.approx(1.0 - np.exp(-10.0))
    assert (state[150:200] == state[149]).all()
    assert state[-1] < state[150]
    assert state == pytest.approx(stepped(rate, 0.01, 0.1), abs=1e-12)


def test_rows_whose_motion_is_not_known_keep_the_state() -> None:
    rate = np.where((T > 5) & (T < 6), np.nan, 1.0)[:, None] * np.ones(3)
    (column, *_) = hysteresis(0.1).columns(replace(RUN, rate=rate), None)  # type: ignore[arg-type]
    assert np.isfinite(column[0]).all()


@pytest.mark.parametrize("first", [0, 3])
def test_a_triad_jumps_once(first: int) -> None:
    term = bias_step(first, 10.0).shaped((4.0,))
    jump = np.array([1e-3, 2e-3, 3e-3])
    change = read((term,), jump) - read((), [])
    expected = np.zeros((len(T), 6))
    expected[T >= 4.0, first : first + 3] = jump
    assert change == pytest.approx(expected, abs=1e-12)


def test_jumps_are_told_half_way_and_a_walk_has_no_parameter() -> None:
    terms = candidates(recording(), RUN)
    assert [t.at for t in terms if t.name == "bias_step"] == 2 * [(0.5 * T[-1],)]
    assert BIAS_RANDOM_WALK in terms
    assert not BIAS_RANDOM_WALK.parameters
