"""The unit's clock against the table's, by when its stamps arrived."""

import numpy as np
import pytest

from tasks.station.stream_readers import compared

OFFSET_S, SKEW, DELAY_S = 0.2, 4e-5, 5e-3
STAMPS_S = np.arange(0.0, 600.0, 0.2)
NO_DOUBT_S = np.zeros(len(STAMPS_S))


def arrived(seed: int, least_s: float = 0.0) -> np.ndarray:
    delays = np.random.default_rng(seed).exponential(DELAY_S, len(STAMPS_S))
    return OFFSET_S + STAMPS_S * (1.0 + SKEW) + least_s + delays


@pytest.mark.parametrize("seed", range(8))
def test_offset_and_skew_are_found_under_delays_that_are_never_negative(seed: int) -> None:
    found = compared(STAMPS_S, arrived(seed), NO_DOUBT_S)
    assert found is not None
    at_start_s = found.offset_s - found.skew * found.at_s
    assert at_start_s == pytest.approx(OFFSET_S, abs=2e-4)
    assert abs(found.skew - SKEW) < 5.0 * found.u_skew
    assert 0.0 < found.u_offset_s < 1e-4


@pytest.mark.parametrize("least_s", [0.0, 0.2, 0.5])
def test_the_offset_is_within_u_whatever_the_least_delay_up_to_the_doubt(least_s: float) -> None:
    """Thirty times the clock: a frame that comes 16 ms after its stamp comes half a second late."""
    found = compared(STAMPS_S, arrived(3, least_s), NO_DOUBT_S + 0.5)
    assert found is not None
    at_start_s = found.offset_s - found.skew * found.at_s
    assert abs(at_start_s - OFFSET_S) < 2.0 * found.u_offset_s
    assert found.u_offset_s < 0.2
    assert abs(found.skew - SKEW) < 5.0 * found.u_skew


def test_answers_of_the_table_that_take_long_are_not_taken_for_an_offset() -> None:
    """A reading that is believed to be of the answer's time is early by up to the whole exchange:
    the latest that it can have been is not."""
    took_s = np.random.default_rng(5).uniform(0.01, 0.4, len(STAMPS_S))
    read_late_s = took_s * np.random.default_rng(6).uniform(0.0, 1.0, len(STAMPS_S))
    found = compared(STAMPS_S, arrived(4) - read_late_s + took_s, took_s)
    assert found is not None
    at_start_s = found.offset_s - found.skew * found.at_s
    assert abs(at_start_s - OFFSET_S) < 2.0 * found.u_offset_s < 0.1


def test_a_clock_without_delays_is_compared_exactly() -> None:
    found = compared(STAMPS_S, OFFSET_S + STAMPS_S * (1.0 + SKEW), NO_DOUBT_S)
    assert found is not None
    assert found.skew == pytest.approx(SKEW, rel=1e-6)
    assert found.u_offset_s < 1e-9


@pytest.mark.parametrize("count", [0, 1, 3])
def test_too_few_stamps_say_nothing(count: int) -> None:
    assert compared(STAMPS_S[:count], STAMPS_S[:count], NO_DOUBT_S[:count]) is None
