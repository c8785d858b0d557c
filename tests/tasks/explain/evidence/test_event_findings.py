"""How clear an event must be to be a finding."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tasks.explain.evidence.event_findings import _needed
from tasks.explain.evidence.shares import WEAK


def needed(effect: str, left: list[float]) -> float:
    event = SimpleNamespace(effect=effect, channels=(3, 4))
    return _needed(cast(Any, event), cast(Any, SimpleNamespace(chi2_per_degree=np.array(left))))


@pytest.mark.parametrize("effect", ["gyro_saturation", "accel_saturation"])
def test_a_limit_must_be_clear_of_what_is_left_in_its_channels(effect: str) -> None:
    quiet = [1.0, 1.0, 1.0, 0.8, 0.9, 50.0]
    assert needed(effect, quiet) == WEAK
    assert needed(effect, [1.0, 1.0, 1.0, 9.0, 11.0, 1.0]) == pytest.approx(10.0 * WEAK)
    assert needed(effect, [np.nan] * 6) == WEAK


def test_other_events_need_only_evidence() -> None:
    assert needed("dropped_samples", [9.0] * 6) == 0.0
