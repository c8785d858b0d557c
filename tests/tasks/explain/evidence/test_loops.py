"""A memory runs round its loops one way."""

import numpy as np
import pytest

from tasks.explain.evidence.loops import loops_both_ways
from tasks.model.parameters import each_axis

PARAMETERS = tuple(
    one for width in ("0.2", "0.8") for one in each_axis(f"amplitude_{width}", "h", ("m/s2", 1, 1))
)
U = np.full(6, 0.01)


@pytest.mark.parametrize(
    ("values", "refused"),
    [
        ((0.1, -0.1, 0.0, 0.3, -0.3, 0.2), False),  # each axis has a direction of its own
        ((0.1, 0.0, 0.0, -0.3, 0.0, 0.0), True),
        ((0.1, 0.0, 0.0, -0.015, 0.0, 0.0), False),  # within its U
    ],
)
def test_clear_weights_of_both_signs_in_one_channel_are_no_memory(
    values: tuple[float, ...], refused: bool
) -> None:
    found = loops_both_ways("hysteresis", PARAMETERS, np.array(values), U)
    assert (found is not None and found.kind == "both_ways") == refused


def test_other_effects_may_have_parameters_of_both_signs() -> None:
    values = np.array([0.1, 0.0, 0.0, -0.3, 0.0, 0.0])
    assert loops_both_ways("temperature_bias", PARAMETERS, values, U) is None
