"""Delays and clocks, against courses that are known at every time."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.model.terms.electronics import BANDWIDTH, corner
from tasks.model.terms.timing import ACCEL_AXIS_SKEW, CLOCK_SKEW, TIME_OFFSET
from tasks.motion.whole import Motion
from tests.tasks.model.table_run import motion

T = np.arange(3000) / 100.0
RUN = replace(motion(), t=T)
INSIDE = slice(300, -300)


def waves(t: np.ndarray) -> np.ndarray:
    """Six channels (n, 6), each with a frequency up to 2 Hz."""
    return np.sin(np.outer(t, 2.0 * np.pi * np.array([0.2, 0.5, 0.9, 1.2, 1.6, 2.0])))


@pytest.mark.parametrize("late", [0.0, 0.0037, -0.0037, 0.01, 0.1234, -1.0])
def test_stamps_that_are_late_say_what_was_before(late):
    delayed = TIME_OFFSET.passed(RUN, waves(T), np.array([late]))
    assert delayed[INSIDE] == pytest.approx(waves(T - late)[INSIDE], abs=1e-6)


@pytest.mark.parametrize("late", [0.0, 0.0037, -0.012, 0.1234])
def test_stamps_that_come_in_batches_are_late_by_seconds_not_rows(late):
    batched = T - 0.6 * 0.01 * (np.arange(len(T)) % 6)
    delayed = TIME_OFFSET.passed(replace(RUN, t=batched), waves(batched), np.array([late]))
    assert delayed[INSIDE] == pytest.approx(waves(batched - late)[INSIDE], abs=1e-3)


def test_uneven_stamps_without_a_known_motion_stay_unknown():
    uneven = replace(RUN, t=T + 0.003 * (np.arange(len(T)) % 3))
    readings = waves(uneven.t)
    readings[100:120] = np.nan
    delayed = TIME_OFFSET.passed(uneven, readings, np.array([0.01]))
    assert np.isnan(delayed[100:120]).all()
    assert np.isfinite(delayed[:90]).all()


@pytest.mark.parametrize("share", [0.0, 1e-5, 2e-3, -2e-3])
def test_a_clock_that_runs_fast_stamps_later_and_later(share):
    skewed = CLOCK_SKEW.passed(RUN, waves(T), np.array([share]))
    assert skewed[INSIDE] == pytest.approx(waves(T / (1.0 + share))[INSIDE], abs=1e-6)


def test_accelerometers_read_one_after_another_are_ahead_of_x():
    skewed = ACCEL_AXIS_SKEW.passed(RUN, waves(T), np.array([0.0021]))
    expected = waves(T)
    expected[:, 4] = waves(T + 0.0021)[:, 4]
    expected[:, 5] = waves(T + 0.0042)[:, 5]
    assert skewed[INSIDE] == pytest.approx(expected[INSIDE], abs=1e-6)
    assert (skewed[:, :4] == waves(T)[:, :4]).all()


@pytest.mark.parametrize("seconds", [0.004, 0.05])
def test_a_low_pass_lowers_and_delays_each_frequency_by_its_response(seconds):
    passed = BANDWIDTH.passed(RUN, waves(T), np.array([seconds]))
    for channel, f in enumerate((0.2, 0.5, 0.9, 1.2, 1.6, 2.0)):
        s = 1j * f / corner(seconds)
        response = 1.0 / (1.0 + np.sqrt(2.0) * s + s**2)
        expected = np.imag(response * np.exp(2j * np.pi * f * T))
        assert passed[INSIDE, channel] == pytest.approx(expected[INSIDE], abs=1e-6)
        assert abs(response) < 1.0


@pytest.mark.parametrize("term", [TIME_OFFSET, CLOCK_SKEW, ACCEL_AXIS_SKEW, BANDWIDTH])
def test_what_is_not_known_spoils_only_what_is_near(term):
    gap = waves(T)
    gap[1000:1200] = np.nan
    passed = term.passed(RUN, gap, np.array([1e-3]))  # type: ignore[attr-defined]
    whole = term.passed(RUN, waves(T), np.array([1e-3]))  # type: ignore[attr-defined]
    assert np.isnan(passed[1010:1190]).all()
    for near in (slice(5, 950), slice(1250, -5)):
        assert passed[near] == pytest.approx(whole[near], abs=1e-6)


def test_a_low_pass_knows_nothing_until_it_has_forgotten_what_is_not_known():
    gap = waves(T)
    gap[1000:1200, 2] = np.nan
    passed = BANDWIDTH.passed(RUN, gap, np.array([0.019]))  # two rows
    unknown = np.flatnonzero(np.isnan(passed[:, 2]))
    assert (unknown[0], unknown[-1]) == (1000 - 15, 1199 + 15)
    assert np.isfinite(passed[:, [0, 1, 3, 4, 5]]).all()


def test_a_low_pass_does_not_ring_at_the_corner_of_a_ramp():
    ramp = np.maximum(T - 15.0, 0.0)[:, None] * np.ones(6)
    change = BANDWIDTH.passed(RUN, ramp, np.array([1e-4])) - ramp
    assert np.abs(change[INSIDE][(T < 14.9)[INSIDE]]).max() < 1e-7
    assert change[2000:2500] == pytest.approx(-np.sqrt(2.0) * 1e-4, rel=1e-3)


@pytest.mark.parametrize("term", [TIME_OFFSET, CLOCK_SKEW, ACCEL_AXIS_SKEW, BANDWIDTH])
def test_nothing_passes_from_one_fixing_of_the_unit_to_the_next(term):
    up = np.where(T[:, None] < 12.0, [0.0, 0.0, 1.0], [0.0, 1.0, 0.0])
    rate = 0.1 * np.ones((len(T), 3))
    run = replace(RUN, up=up, rate=rate)
    assert run.takes == (slice(0, 1200), slice(1200, len(T)))
    fixed = np.where(T[:, None] < 12.0, 9.8, -9.8) * np.ones(6)
    for value in (1e-3, 0.03):
        assert term.passed(run, fixed, np.array([value])) == pytest.approx(fixed)  # type: ignore[attr-defined]


def test_every_signal_term_is_linear_in_the_readings():
    one, other = waves(T), waves(0.5 * T + 1.0)
    run: Motion = RUN
    for term in (TIME_OFFSET, CLOCK_SKEW, ACCEL_AXIS_SKEW, BANDWIDTH):
        both = term.passed(run, 2.0 * one - other, np.array([2e-3]))
        apart = 2.0 * term.passed(run, one, np.array([2e-3])) - term.passed(
            run, other, np.array([2e-3])
        )
        assert both == pytest.approx(apart, abs=1e-12)


@pytest.mark.parametrize("term", [TIME_OFFSET, CLOCK_SKEW])
def test_what_is_constant_stays_exactly_so_also_after_unknown_rows(term):
    readings = np.full((len(T), 6), 9.80665)
    readings[1000:] = -0.0123
    readings[:3] = np.nan
    change = term.passed(RUN, readings, np.array([3.7e-3])) - readings
    assert not change[20:900].any()
    assert not change[1100:].any()
