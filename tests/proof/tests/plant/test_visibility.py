"""Visibility: against a closed formula, and as a dial."""

import numpy as np
import pytest

from tests.proof.plant.case import GYRO_NOISE
from tests.proof.plant.simulate import at_visibility, simulate, visibility, visibility_of
from tests.proof.tests.plant.short_case import case_of

LINE = {"gyro": [3e-4, 0.0, 0.0], "accel": [0.0, 0.0, 0.0], "frequency": 9.0}


def test_a_line_in_the_white_band_is_as_visible_as_its_energy() -> None:
    made = simulate(case_of("x_beat_line", **LINE))
    found = visibility(made, "x_beat_line")
    energy = 3e-4**2 / 2.0 * len(made.truth)
    density = GYRO_NOISE["industrial"].density(np.array(9.0)) * 50.0
    assert found.z == pytest.approx(np.sqrt(energy / density), rel=0.01)
    assert found.concealment < 0.01


def test_what_the_standard_absorbs_is_concealed() -> None:
    found = visibility_of(case_of("gravity_value"), "gravity_value")
    assert found.z < 1e-3
    assert found.concealment > 0.999999
    with pytest.raises(ValueError, match="cannot be seen"):
        at_visibility(case_of("gravity_value"), "gravity_value", 10.0)


def test_an_effect_is_judged_beside_the_others() -> None:
    case = case_of("x_beat_line", **LINE)
    both = case.model_copy(update={"effects": case.effects + case_of("lever_arm").effects})
    alone, beside = visibility_of(case, "x_beat_line"), visibility_of(both, "x_beat_line")
    assert beside.z == pytest.approx(alone.z, rel=1e-3)


@pytest.mark.parametrize(("name", "z"), [
    ("lever_arm", 60.0), ("bandwidth", 10.0), ("gyro_saturation", 60.0),
    ("encoder_eccentricity", 10.0), ("coarse_quantisation", 10.0), ("x_cable_drag", 30.0),
])  # fmt: skip
def test_the_strength_is_set_to_a_visibility(name: str, z: float) -> None:
    case = at_visibility(case_of(name, fields={"rate_hz": 25}), name, z)
    assert visibility_of(case, name).z == pytest.approx(z, rel=0.05)


def test_what_would_have_to_be_absurd_is_refused() -> None:
    case = case_of("x_beat_line", **LINE)
    with pytest.raises(ValueError, match="times its typical size"):
        at_visibility(case, "x_beat_line", 1e5)


def test_the_earth_is_not_turned_faster() -> None:
    case = case_of("earth_rotation")
    assert at_visibility(case, "earth_rotation", 100.0) == case
