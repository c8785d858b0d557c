"""The unit's clock against the table's, by when its stamps arrived."""

import numpy as np
import pytest

from tasks.station.time_base import compared

OFFSET_S, SKEW, DELAY_S = 0.2, 4e-5, 5e-3
STAMPS_S = np.arange(0.0, 600.0, 0.2)


def arrived(seed: int) -> np.ndarray:
    delays = np.random.default_rng(seed).exponential(DELAY_S, len(STAMPS_S))
    return OFFSET_S + STAMPS_S * (1.0 + SKEW) + delays


@pytest.mark.parametrize("seed", range(8))
def test_offset_and_skew_are_found_under_delays_that_are_never_negative(seed: int) -> None:
    found = compared(STAMPS_S, arrived(seed))
    assert found is not None
    at_start_s = found.offset_s - found.skew * found.at_s
    assert at_start_s == pytest.approx(OFFSET_S, abs=2e-4)
    assert abs(found.skew - SKEW) < 5.0 * found.u_skew
    assert 0.0 < found.u_offset_s < 1e-4


def test_a_clock_without_delays_is_compared_exactly() -> None:
    found = compared(STAMPS_S, OFFSET_S + STAMPS_S * (1.0 + SKEW))
    assert found is not None
    assert found.skew == pytest.approx(SKEW, rel=1e-6)
    assert found.u_offset_s < 1e-9


@pytest.mark.parametrize("count", [0, 1, 3])
def test_too_few_stamps_say_nothing(count: int) -> None:
    assert compared(STAMPS_S[:count], STAMPS_S[:count]) is None
