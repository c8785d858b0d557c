"""Unlisted forms: what their columns span, what their weights cost, and when they are selected."""

import numpy as np
import pytest
from engine_run import NOISY, motion, noise, observed, read

from tasks.explain.search.behaviours import behaviours
from tasks.explain.search.candidates import (
    Candidate,
    Weights,
    candidates_of,
    plausible_half_ranges,
)
from tasks.explain.search.design import banded_design
from tasks.explain.search.stepwise import Selection, search
from tasks.model.term import Inputs, Term
from tasks.model.terms.environment import TEMPERATURE_BIAS
from tasks.model.terms.gyro import gyro_scale_nonlinearity
from tasks.model.terms.hysteresis import hysteresis
from tasks.motion.lag import first_order_lag

RUN = motion()
TOP = float(np.abs(RUN.rate).max())
LISTED: tuple[Term, ...] = (hysteresis(0.1), gyro_scale_nonlinearity(3, TOP), TEMPERATURE_BIAS)


def columns(name: str, channel: int) -> np.ndarray:
    """(n, k) of an unlisted form in one channel."""
    for term in behaviours(RUN):
        own = [each[channel] for each in term.columns(RUN, Inputs.of(RUN)) if channel in each]
        if term.name == name and own:
            return np.column_stack(own)
    raise AssertionError(name)


def left_of(course: np.ndarray, basis: np.ndarray) -> float:
    """Share of the power of a course (n,) that columns and a constant do not take."""
    basis = np.column_stack([basis, np.ones(len(basis))])
    rest = course - basis @ np.linalg.lstsq(basis, course, rcond=1e-9)[0]
    return float(rest @ rest / ((course - course.mean()) ** 2).sum())


def fast_spin(share: float) -> np.ndarray:
    """(n,) sign of the last turn about x that was faster than a share of the largest rate."""
    state, found = 0.0, np.zeros(len(RUN.t))
    for row, rate in enumerate(RUN.rate[:, 0].tolist()):
        state = float(np.sign(rate)) if abs(rate) > share * TOP else state
        found[row] = state
    return found


def selected(made: np.ndarray) -> Selection:
    """What a search of the listed terms and of every unlisted form selects."""
    readings = made + noise(len(RUN.t), 3, NOISY)
    blocks = observed(readings, RUN)
    tried, own = candidates_of([*LISTED, *behaviours(RUN)], RUN)
    half = plausible_half_ranges(tried, len(own))
    return search(banded_design(blocks, readings, own, half), tried)


@pytest.fixture(scope="module")
def remembered() -> Selection:
    made = read(RUN)
    made[:, 0] += 4e-5 * fast_spin(0.6)
    return selected(made)


def test_columns_are_known_wherever_the_motion_is() -> None:
    for term in behaviours(RUN):
        for column in term.columns(RUN, Inputs.of(RUN)):
            assert len(column) == 1
            assert np.isfinite(next(iter(column.values()))).all()


def test_a_memory_of_the_last_fast_turn_is_among_the_hystereses() -> None:
    assert left_of(fast_spin(0.6), columns("hysteresis", 0)) < 0.05


@pytest.mark.parametrize("bend", [np.abs, lambda x: x**3 - x**5, np.tanh])
def test_a_curve_of_the_own_rate_is_among_the_non_linearities(bend) -> None:
    course = bend(RUN.rate[:, 1] / TOP)
    assert left_of(course, columns("gyro_scale_nonlinearity", 1)) < 5e-3


def test_a_distribution_of_lags_has_any_lag() -> None:
    temperature = RUN.recorded["temperature"] - RUN.recorded["temperature"][0]
    late = first_order_lag(temperature, RUN.interval, 60.0)
    assert left_of(late, columns("temperature_bias", 4)) < 1e-3


def test_weights_have_one_variance_in_the_readings_units() -> None:
    power = np.array([4.0, 1.0, 0.0, 16.0])  # of two channels: the clearest column sets the unit
    precision = Weights(100.0, 2).precision(power)
    np.testing.assert_allclose(precision[:2], [0.01, 0.04])
    assert precision[3] == pytest.approx(0.01)
    assert precision[2] > 1e8


def test_a_memory_of_no_listed_form_is_one_finding_of_its_kind(remembered: Selection) -> None:
    (one,) = remembered.candidates
    assert (one.name, one.unlisted) == ("hysteresis", True)


@pytest.mark.parametrize(("term", "size"), [(LISTED[0], 3e-4), (LISTED[1], 2e-3)])
def test_a_listed_form_keeps_its_place(term: Term, size: float) -> None:
    found = selected(read(RUN, (term, [size, -size, 0.0])))
    assert [(one.name, one.unlisted) for one in found.candidates] == [(term.name, False)]


def test_nothing_is_selected_in_noise() -> None:
    assert not selected(read(RUN)).candidates


def test_an_unlisted_form_is_no_form_of_its_name(remembered: Selection) -> None:
    one: Candidate = remembered.candidates[0]
    assert not one.is_form_of(("hysteresis",))
