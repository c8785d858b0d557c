"""Ranges, units and axes that are set wrong are told, and a working unit's are left alone."""

from dataclasses import replace

import numpy as np
import pytest

from tasks.explain.events.bursts import find_settling
from tasks.explain.events.detect import (
    AxisMapping,
    GravityRemoved,
    RangeSetting,
    Setting,
    events_in_readings,
    find_gravity_removed,
    find_settings,
)
from tasks.words import texts
from tests.tasks.explain.events.made_up import counted, mean_readings, motion, noisy

SWAPPED = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
MADE = motion(minutes=6.0)
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


def settings(readings: np.ndarray, tracked: bool = False) -> tuple[Setting, ...]:
    found = find_settings(readings, MADE, tracked)
    assert all(all(texts(setting.description).values()) for setting in found)
    return found


@pytest.mark.parametrize("seed", range(4))
def test_a_working_unit_has_no_wrong_setting(seed):
    rng = np.random.default_rng(seed)
    scale = 1.0 + rng.normal(0.0, 0.02, 6)
    assert settings(noisy(mean_readings(MADE) * scale, seed)) == ()


@pytest.mark.parametrize(
    ("triad", "factor"),
    [(0, 2.0), (0, 0.25), (0, 180.0 / np.pi), (0, np.pi / 180.0), (0, 1.43), (1, 1.16),
     (1, 1.0 / 9.80665), (1, 9.80665), (1, 0.5), (1, 1000.0)],
)  # fmt: skip
def test_a_factor_common_to_a_triad_is_a_setting(triad, factor):
    readings = noisy(mean_readings(MADE), 2)
    right = readings.copy()
    readings[:, 3 * triad : 3 * triad + 3] *= factor
    (found,) = settings(readings)
    assert isinstance(found, RangeSetting)
    assert found.triad == triad
    (parameter,) = found.parameters
    assert abs(parameter.value - factor) <= 2.0 * parameter.u + 1e-12
    undone = found.undone(readings)
    np.testing.assert_allclose(undone, right, rtol=0.01, atol=1e-9)
    np.testing.assert_allclose(found.applied(MADE.t, undone), readings, rtol=1e-6, atol=1e-12)


def test_one_axis_off_by_a_factor_is_no_setting_of_the_triad():
    readings = noisy(mean_readings(MADE), 3)
    readings[:, 1] *= 2.0
    assert settings(readings) == ()


def test_an_unusual_factor_about_one_axis_alone_may_be_the_tables():
    made = MADE
    rate = made.rate.copy()
    rate[:, :2] = 0.0
    about_z = replace(made, rate=rate)
    readings = noisy(mean_readings(about_z), 4)
    for factor, expected in ((1.4, []), (0.5, [0.5])):
        scaled = readings.copy()
        scaled[:, :3] *= factor
        found = find_settings(scaled, about_z, False)
        assert [one.factor for one in found if isinstance(one, RangeSetting)] == expected


def test_readings_that_do_not_follow_the_motion_have_no_setting():
    readings = noisy(mean_readings(MADE), 5)
    readings[:, :3] = 0.4 * np.roll(readings[:, :3], 900, axis=0)
    assert settings(readings) == ()


@pytest.mark.parametrize("triad", [0, 1])
@pytest.mark.parametrize("matrix", [SWAPPED, np.diag([1.0, -1.0, 1.0]), QUARTER])
def test_axes_of_one_triad_exchanged_or_inverted_are_told(triad, matrix):
    right = noisy(mean_readings(MADE), 6)
    readings = right.copy()
    own = slice(3 * triad, 3 * triad + 3)
    readings[:, own] = right[:, own] @ matrix.T
    (found,) = settings(readings, tracked=True)
    assert isinstance(found, AxisMapping)
    assert np.array_equal(found.matrix, matrix)
    np.testing.assert_allclose(found.undone(readings), right, rtol=1e-6, atol=1e-12)
    assert found.indistinguishable == ()


def test_both_triads_turned_alike_may_be_the_mount_and_of_a_tracked_body_is_its_own():
    right = noisy(mean_readings(MADE), 7)
    readings = np.hstack([right[:, :3] @ QUARTER.T, right[:, 3:] @ QUARTER.T])
    found = settings(readings)
    assert [setting.effect for setting in found] == ["axis_mapping", "axis_mapping"]
    assert all(setting.indistinguishable == ("reference_frame",) for setting in found)
    assert settings(readings, tracked=True) == ()


def test_a_turn_that_gravity_does_not_show_is_that_of_a_tracked_body_too():
    """Level all the time: turned about its vertical the accelerometers read as they did."""
    level = replace(MADE, up=np.tile([0.0, 0.0, 1.0], (len(MADE.t), 1)))
    readings = noisy(mean_readings(level), 7)
    readings[:, :3] = readings[:, :3] @ QUARTER.T
    assert find_settings(readings, level, True) == ()
    (found,) = find_settings(readings, level, False)
    assert found.triad == 0
    assert found.indistinguishable == ("reference_frame",)


def test_axes_and_range_are_undone_together():
    right = counted(noisy(mean_readings(MADE), 8))
    readings = right.copy()
    readings[:, :3] = 4.0 * right[:, :3] @ SWAPPED.T
    found = settings(readings)
    assert [setting.effect for setting in found] == ["axis_mapping", "range_setting"]
    for setting in reversed(found):
        readings = setting.undone(readings)
    np.testing.assert_allclose(readings, right, rtol=1e-6, atol=1e-12)


def test_gravity_that_a_driver_took_off_is_put_back():
    right = noisy(mean_readings(MADE), 8)
    removed = right.copy()
    removed[:, 3:] -= MADE.force
    found = find_gravity_removed(removed, MADE)
    assert isinstance(found, GravityRemoved)
    np.testing.assert_allclose(found.undone(removed), right, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.applied(MADE.t, right), removed, rtol=1e-9, atol=1e-9)
    assert find_gravity_removed(right, MADE) is None
    assert settings(found.undone(removed)) == ()


# Ends that settle or are torn are not used; drifts, ramps and single spikes are none of them.

MADE_SETTLING = motion()
ROWS = len(MADE_SETTLING.t)


def readings() -> np.ndarray:
    return noisy(mean_readings(MADE_SETTLING), 1)


def test_ends_like_the_rest_are_used():
    masked, remarks = find_settling(readings(), MADE_SETTLING)
    assert not masked.any()
    assert remarks == ()


@pytest.mark.parametrize("tau", [0.01, 0.05, 0.1])
def test_a_filter_that_begins_empty_is_left_out_until_it_has_settled(tau):
    made = readings()
    made *= -np.expm1(-MADE_SETTLING.t / tau)[:, None]
    masked, (remark,) = find_settling(made, MADE_SETTLING)
    left = np.exp(-MADE_SETTLING.t / tau)[~masked.all(axis=1)]
    assert left.max() < 1e-3
    assert masked[:, 0].sum() * MADE_SETTLING.interval < 20.0 * tau
    assert not masked[ROWS // 2 :].any()
    assert all(texts(remark).values())


@pytest.mark.parametrize("row", [0, -1])
def test_one_torn_row_at_an_end_is_left_out(row):
    made = readings()
    made[row] = 0.0
    events = events_in_readings(made, MADE_SETTLING)
    assert events.masked[row].all()
    assert events.masked.sum() < 30
    assert len(events.remarks) == 1


def test_a_drift_that_is_fastest_at_the_start_is_used():
    made = readings()
    made += 0.05 * np.exp(-MADE_SETTLING.t / 20.0)[:, None]
    assert not find_settling(made, MADE_SETTLING)[0].any()


def test_readings_that_are_late_at_every_ramp_are_used():
    made = np.roll(readings(), 8, axis=0)
    made[:8] = made[8]
    assert not find_settling(made, MADE_SETTLING)[0].any()
