"""Which parameters are held at nothing: one after the other, the least clear first."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tasks.explain.evidence.determination import _undetermined
from tasks.explain.evidence.evidence import Evidence


def undetermined(values: tuple[float, ...], covariance: np.ndarray) -> list[bool]:
    """Of one finding whose parameters have these values, be it of one effect or of several."""
    count = len(values)
    model = SimpleNamespace(
        values=np.array(values), covariance=covariance, free=np.ones(count, bool)
    )
    finding = SimpleNamespace(random=False)
    own = ((list(range(count)), np.array(values)),)
    evidence: Any = SimpleNamespace(fit=SimpleNamespace(model=model), groups=[finding], own=own)
    return _undetermined(cast(Evidence, evidence), cast(Any, {0: None}), np.ones(count)).tolist()


def test_what_is_no_larger_than_its_u_is_held_at_nothing() -> None:
    assert undetermined((5.0, 1.9, -2.1), np.eye(3)) == [False, True, False]


@pytest.mark.parametrize("r", [0.99, -0.99])
def test_of_two_that_make_up_for_each_other_one_stays(r: float) -> None:
    """Neither is larger than its U, but without the one the other is clear."""
    covariance = np.eye(3)
    covariance[1, 2] = covariance[2, 1] = -r
    values = (9.0, 1.5, np.sign(r) * 1.4)
    assert undetermined(values, covariance) == [False, False, True]


def test_the_last_of_a_finding_stays() -> None:
    assert undetermined((0.3, 0.1), np.eye(2)) == [False, True]
