"""The stated time of a step holds the true one, and a gap of the readings widens it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from engine_run import NOISY, QUIET, RATE, WHITE, motion, noise, observed, read

from tasks.explain.evidence.step_time import step_time
from tasks.explain.search.candidates import Candidate
from tasks.explain.search.design import NormalEquations
from tasks.explain.search.fitted import FittedSelection
from tasks.explain.search.stepwise import Selected, Selection
from tasks.model.terms.memory import bias_step

RUN = motion()
TRUE = 163.211  # s, between two blocks
NOTHING = NormalEquations(np.zeros((0, 0)), np.zeros(0), np.zeros(0), 0.0)


def timed(made: np.ndarray, at: float, **changes: Any) -> tuple[float, float]:
    """The time of a step of gyro y that a search put at a time, s, and its u."""
    step, blocks = bias_step(0, at), replace(observed(made, RUN), **changes)
    picked = Selected(Candidate(step, (1,), (1,), 1), 100.0, 90.0, ())
    fit = FittedSelection.of(Selection((picked,), NOISY, 1e-9, NOTHING), blocks, RATE)
    return step_time(fit, fit.model.terms[-1], 1.0)


def stepped(size: float, seed: int) -> np.ndarray:
    """Readings with a step of gyro y, in standard deviations of a block."""
    made = read(RUN) + noise(len(RUN.t), seed, QUIET)
    made[RUN.t >= TRUE, 1] += size * WHITE[1]
    return made


@pytest.mark.parametrize("size", [0.7, 1.5, 6.0])
def test_the_expanded_uncertainty_covers_the_true_time(size: float) -> None:
    inside = []
    for seed in range(16):
        time, u = timed(stepped(size, seed), TRUE)
        inside.append(abs(time - TRUE) <= 2.0 * u)
        assert 0.0 < 2.0 * u < 60.0 / RATE / size**2 + 2.0 / RATE
    assert np.mean(inside) >= 0.9


def test_in_a_gap_of_the_readings_it_may_lie_anywhere() -> None:
    weight = np.where((RUN.t > 155.0) & (RUN.t < 175.0), 0.0, 1.0)[:, None].repeat(6, axis=1)
    time, u = timed(stepped(6.0, 3), 175.0, weight=weight)
    assert time == pytest.approx(165.0, abs=0.2)
    assert 2.0 * u == pytest.approx(10.0, abs=0.2)


@pytest.mark.parametrize("unknown", [(155.0, 175.0), (390.0, 400.0)])
def test_unknown_motion_is_as_a_gap_of_the_readings(unknown: tuple[float, float]) -> None:
    hidden = (RUN.t > unknown[0]) & (RUN.t < unknown[1])
    weight = np.where(hidden, 0.0, 1.0)[:, None].repeat(6, axis=1)
    lost = RUN.mapped(lambda values: np.where(hidden.reshape(-1, *[1] * (values.ndim - 1)),
                                              np.nan, values))  # fmt: skip
    lost = replace(lost, t=RUN.t)
    at = 175.0 if hidden[np.searchsorted(RUN.t, TRUE)] else TRUE
    known = timed(stepped(1.0, 6), at, weight=weight)
    assert timed(stepped(1.0, 6), at, weight=weight, motion=lost) == pytest.approx(known, abs=0.02)


def test_a_band_of_poses_shows_no_time_more_closely_than_its_edge() -> None:
    _, u = timed(stepped(30.0, 4), TRUE, band=2.0)
    assert 2.0 * u == pytest.approx(0.25, abs=0.1)
