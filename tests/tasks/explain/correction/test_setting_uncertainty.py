"""U after a setting was put right is that of the whole reading, not of what was taken off."""

import numpy as np
import pytest

from schemas.discrepancy import FoundParameter
from storage.formats.folder import read_folder
from tasks.explain.correction.consequences import consequences
from tasks.explain.correction.sensitivity import uncertain_inputs
from tasks.explain.explain import explain
from tasks.explain.explanation import Finding
from tests.shared import shared_path


@pytest.mark.parametrize("factor", [0.5, 1.14, 2.0, 57.2958])
def test_a_factor_is_as_uncertain_as_the_reading_that_it_multiplies(factor: float) -> None:
    right = np.linspace(-3.0, 3.0, 60).reshape(10, 6)
    found = FoundParameter(name="factor", value=factor, unit="1", u=0.01 * factor)
    setting = Finding(
        "range_setting", "", "", "", "", (0, 1, 2), (found,), (factor - 1.0) * right, 1.0, 1.0, 1.0
    )
    (one,) = uncertain_inputs([setting], None)
    assert np.allclose(np.abs(one.change(None)), np.abs(0.01 * right))


def test_the_scale_factor_after_a_range_put_right_has_the_factors_relative_uncertainty() -> None:
    recording = read_folder(shared_path("data/field/gyro_range_1137"))
    explanation = explain(recording)
    effects = consequences(recording, explanation)
    which = [each.effect for each in explanation.findings].index("range_setting")
    scale = {
        each.element: each
        for each in effects.of_findings[which]
        if each.item == "gyro_scale_factor"
    }
    assert set(scale) == {"x", "y", "z"}
    for one in scale.values():
        assert one.after is not None
        assert pytest.approx(0.02 * one.after, rel=0.02) == one.U
