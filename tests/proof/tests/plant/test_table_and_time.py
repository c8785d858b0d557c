"""Table and clocks: who sees what, and when."""

import numpy as np
import pytest

from tests.proof.tests.plant.short_case import case_of, in_segment, noise_free


def test_ripple_is_in_the_gyro_and_not_in_the_encoder() -> None:
    run = noise_free(case_of("rate_ripple", depth=1e-3, per_turn=8, phase=0.4))
    clean = noise_free(case_of())
    assert np.array_equal(run.table_rates, clean.table_rates)
    rows = in_segment(run, "rate_z_+200")
    rate = np.radians(200.0)
    ripple = 1e-3 * rate * np.cos(8 * run.table_angles[0][rows] + 0.4)
    observation = np.linalg.solve(run.unit.Kg, (run.truth - run.nominal)[:3, rows])[2]
    assert np.abs(observation - ripple).max() < 0.01 * 1e-3 * rate


def test_eccentricity_is_in_the_encoder_and_not_in_the_unit() -> None:
    run = noise_free(case_of("encoder_eccentricity", amplitude=1e-3, phase=0.4))
    clean = noise_free(case_of())
    assert np.array_equal(run.truth, clean.truth)
    wave = 1e-3 * (np.sin(clean.table_angles[0] + 0.4) - np.sin(0.4))
    assert np.allclose(run.table_angles[0] - clean.table_angles[0], wave, atol=1e-9)
    rows = in_segment(run, "rate_z_+200")
    assert np.ptp(run.table_rates[0, rows]) == pytest.approx(2e-3 * np.radians(200), rel=0.01)


def test_a_long_table_scale_turns_the_unit_less_than_reported() -> None:
    run = noise_free(case_of("table_scale", scale=1e-3))
    assert np.array_equal(run.table_angles, noise_free(case_of()).table_angles)
    rows = in_segment(run, "rate_z_+200")
    gyro = np.linalg.solve(run.unit.Kg, (run.truth - run.nominal)[:3, rows].mean(axis=1))
    assert gyro[2] == pytest.approx(-np.radians(200.0) * 1e-3, rel=2e-3)
    level = in_segment(run, "position_+y_000")
    felt = np.linalg.solve(run.unit.Ka, (run.truth - run.nominal)[3:, level].mean(axis=1))
    assert felt[2] == pytest.approx(9.8015 * 1e-3 * np.pi / 2, rel=2e-3)


def test_late_stamps_show_what_was_before() -> None:
    run, clean = noise_free(case_of("time_offset", seconds=0.02)), noise_free(case_of())
    assert np.allclose(run.truth[:, 2:], clean.truth[:, :-2], atol=1e-9)
    assert np.array_equal(run.table_angles, clean.table_angles)


def test_a_part_of_a_sample_is_interpolated_well() -> None:
    there, clean = noise_free(case_of("time_offset", seconds=0.0037)), noise_free(case_of())
    expected = clean.truth - 0.0037 * np.gradient(clean.truth, 0.01, axis=1)
    moves = slice(1050, 1350)
    change = np.abs(there.truth - clean.truth)[:, moves].max()
    assert np.abs(there.truth - expected)[:, moves].max() < 0.03 * change


def test_a_fast_clock_slips_in_proportion_to_time() -> None:
    run, clean = noise_free(case_of("clock_skew", share=1e-4)), noise_free(case_of())
    slope = np.gradient(clean.truth, 0.01, axis=1)
    late = slice(-3000, -1500)  # the last ramps
    shift = (slope * (run.truth - clean.truth))[:, late].sum() / (slope**2)[:, late].sum()
    assert shift == pytest.approx(-1e-4 * run.stamp[late].mean(), rel=0.1)


def test_accelerometers_are_sampled_one_after_another() -> None:
    run, clean = noise_free(case_of("accel_axis_skew", step=0.01)), noise_free(case_of())
    assert np.allclose(run.truth[:4], clean.truth[:4], atol=1e-9)
    assert np.allclose(run.truth[4, :-1], clean.truth[4, 1:], atol=1e-9)
    assert np.allclose(run.truth[5, :-2], clean.truth[5, 2:], atol=1e-9)


def test_lost_samples_leave_fewer_rows_and_even_stamps() -> None:
    run, clean = (
        noise_free(case_of("dropped_samples", times=[20.0, 60.0], lost=[3, 5])),
        noise_free(case_of()),
    )
    assert run.truth.shape[1] == clean.truth.shape[1] - 8
    assert np.allclose(np.diff(run.stamp), 0.01)
    assert np.array_equal(run.truth[:, :2000], clean.truth[:, :2000])
    assert np.array_equal(run.truth[:, 5997:], clean.truth[:, 6005:])
    assert len(run.table_t) == clean.truth.shape[1]
