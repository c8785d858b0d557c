"""Ripple, eccentricity and scale, against shafts that stand elsewhere than the encoders say."""

import numpy as np
import pytest

from tasks.model.terms.table import (
    TABLE_SCALE,
    candidates,
    encoder_eccentricity,
    rate_ripple,
)
from tests.tasks.model.table_run import (
    ANGLES,
    attitude,
    felt,
    motion,
    read,
    recording,
    undisturbed,
)

INSIDE = slice(2, -2)


def difference(shaft: np.ndarray) -> np.ndarray:
    return (felt(attitude(shaft)) - undisturbed())[INSIDE]


@pytest.mark.parametrize("axis", [1, 2, 3])
def test_a_ripple_is_a_shaft_ahead_and_behind(axis):
    n, s, c = 5, 6e-4, -4e-4
    shaft = ANGLES.copy()
    theta = ANGLES[:, axis - 1]
    shaft[:, axis - 1] += (s * np.sin(n * theta) + c * np.cos(n * theta)) / n
    term = (read((rate_ripple(n, axis),), [s, c]) - read((), []))[INSIDE]
    assert term == pytest.approx(difference(shaft), abs=2e-6)
    assert np.abs(term[:, :3]).max() > 1e-4


@pytest.mark.parametrize("axis", [1, 3])
def test_an_encoder_that_errs_has_a_shaft_that_is_less_far(axis):
    s, c = 2e-4, 3e-4
    shaft = ANGLES.copy()
    theta = ANGLES[:, axis - 1]
    shaft[:, axis - 1] -= s * np.sin(theta) + c * np.cos(theta)
    term = (read((encoder_eccentricity(axis),), [s, c]) - read((), []))[INSIDE]
    assert term == pytest.approx(difference(shaft), abs=2e-6)


def test_the_scale_of_all_encoders_is_exact_however_large():
    term = (read((TABLE_SCALE,), [2e-3]) - read((), []))[INSIDE]
    assert term == pytest.approx(difference(ANGLES / 1.002), abs=3e-6)
    assert np.abs(term[:, 3:]).max() > 0.03


def test_axes_that_went_round_are_searched_for_what_comes_again_each_turn():
    terms = candidates(recording(), motion())
    assert {t.at[1] for t in terms if t.name == "rate_ripple"} == {1.0}
    assert [t.at[0] for t in terms if t.name == "rate_ripple"] == list(range(2, 25))
