"""A lever arm stands alone where the accelerometers, were they apart, would have shown it."""

from dataclasses import replace

import numpy as np
import pytest
from engine_run import NOISY, motion, noise, observed, read

from tasks.explain.search.candidates import Candidate, columns_of
from tasks.explain.search.design import banded_design
from tasks.explain.search.special_case import departure_shown, places_apart
from tasks.explain.search.stepwise import search
from tasks.model.terms.geometry import LEVER_ARM, SIZE_EFFECT
from tasks.motion.whole import Motion

RUN = motion()
NOISE = noise(len(RUN.t), 3, NOISY)
ARM = np.array([0.0004, -0.0006, 0.00023])  # small: the noise is told beside it


def shown(run: Motion, own: tuple[int, ...] = tuple(range(9))) -> float:
    """own: the places that are among the columns, in the order of the term's parameters."""
    made = read(run, (LEVER_ARM, ARM)) + NOISE
    blocks = observed(made, run)
    of_places = columns_of(SIZE_EFFECT, run)
    columns = [*columns_of(LEVER_ARM, run), *(of_places[k] for k in own)]
    arm = Candidate(LEVER_ARM, (0, 1, 2), (0, 1, 2), 1)
    places = Candidate(SIZE_EFFECT, tuple(range(3, 3 + len(own))), own, 1)
    design = banded_design(blocks, made, columns, np.full(len(columns), np.inf))
    equations = search(design, [arm, places], (), NOISY).equations
    return departure_shown(equations, places, (), ARM)


def left_by_a_lever_arm(places: np.ndarray) -> float:
    """Chi-squared of the noise, and of places of their own, that a lever arm and the standard
    leave.
    """
    made = read(RUN, (SIZE_EFFECT, places)) + NOISE
    design = banded_design(observed(made, RUN), made, [*columns_of(LEVER_ARM, RUN)],
                           np.full(3, np.inf))  # fmt: skip
    arm = Candidate(LEVER_ARM, (0, 1, 2), (0, 1, 2), 1)
    equations = search(design, [arm], (), NOISY).equations
    made_up = equations.right @ np.linalg.pinv(equations.normal) @ equations.right
    return float(equations.misfit - made_up)


def test_places_apart_have_the_lever_arm_for_their_mean_and_its_size_for_their_spread() -> None:
    places = places_apart(ARM).reshape(3, 3)
    assert places.mean(axis=0) == pytest.approx(ARM)
    assert np.sqrt(((places - ARM) ** 2).mean()) == pytest.approx(
        np.sqrt(2.0 / 3.0) * np.linalg.norm(ARM) / np.sqrt(3.0)
    )


def test_what_is_expected_is_what_departures_show_on_average() -> None:
    rng = np.random.default_rng(5)
    size = np.linalg.norm(ARM) / np.sqrt(3.0)
    none = left_by_a_lever_arm(np.zeros(9))
    drawn = [left_by_a_lever_arm(size * rng.standard_normal(9)) - none for _ in range(24)]
    assert np.mean(drawn) == pytest.approx(shown(RUN), rel=0.3)


def test_a_unit_that_hardly_turns_shows_nothing() -> None:
    slow = replace(RUN, rate=0.02 * RUN.rate, acceleration=0.02 * RUN.acceleration)
    assert shown(slow) < 0.01 * shown(RUN)


def test_some_of_the_places_show_less_than_all() -> None:
    assert 0.0 < shown(RUN, (0, 1, 2, 3, 4)) < shown(RUN)


def test_about_one_axis_no_departure_shows() -> None:
    turning = replace(RUN, rate=RUN.rate * (0, 0, 1), acceleration=RUN.acceleration * (0, 0, 1))
    assert shown(turning) < 1e-6 * shown(RUN)
