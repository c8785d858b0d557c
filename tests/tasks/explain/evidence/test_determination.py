"""Which parameters are held at nothing: one after the other, the least clear first."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tasks.explain.evidence.determination import undetermined


def held(values: tuple[float, ...], covariance: np.ndarray) -> list[bool]:
    """Of one finding whose parameters have these values, be it of one effect or of several."""
    count = len(values)
    model: Any = SimpleNamespace(values=np.array(values), covariance=covariance)
    return undetermined(model, [set(range(count))], np.ones(count)).tolist()


def test_what_is_no_larger_than_its_u_is_held_at_nothing() -> None:
    assert held((5.0, 1.9, -2.1), np.eye(3)) == [False, True, False]


@pytest.mark.parametrize("r", [0.99, -0.99])
def test_of_two_that_make_up_for_each_other_one_stays(r: float) -> None:
    """Neither is larger than its U, but without the one the other is clear."""
    covariance = np.eye(3)
    covariance[1, 2] = covariance[2, 1] = -r
    values = (9.0, 1.5, np.sign(r) * 1.4)
    assert held(values, covariance) == [False, False, True]


def test_the_last_of_a_finding_stays() -> None:
    assert held((0.3, 0.1), np.eye(2)) == [False, True]
