"""A lag of first order, against its closed form."""

import numpy as np
import pytest

from tasks.motion.lag import first_order_lag

STEP, TAU = 0.01, 0.5


def test_a_step_is_approached_with_the_time_constant() -> None:
    row = np.arange(1, 301)
    found = first_order_lag(np.ones(len(row)), STEP, TAU)
    assert found == pytest.approx(1.0 - np.exp(-row * STEP / TAU), abs=1e-12)


def test_what_was_in_balance_before_stays_so() -> None:
    assert first_order_lag(np.full(300, 7.0), STEP, TAU, start=7.0) == pytest.approx(7.0)
