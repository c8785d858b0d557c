"""Memory, and the physics outside the catalogue."""

import json

import numpy as np
import pytest

from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.effects import CATALOGUE, EFFECTS, OUTSIDE
from tests.proof.plant.simulate import NoiseFree, without_noise
from tests.proof.tests.plant.short_case import case_of, in_segment, noise_free


def excess(run: NoiseFree) -> np.ndarray:
    return run.truth - run.nominal


def test_a_gyro_s_bias_remembers_the_way_it_turned() -> None:
    run = noise_free(case_of("hysteresis", amplitude=[0, 0, 1e-3]))
    for name, sign in (("rate_z_-50", -1), ("rate_z_+50", 1), ("rest2_z", 1)):
        assert excess(run)[2, in_segment(run, name)].mean() == pytest.approx(sign * 1e-3, rel=1e-3)
    assert np.abs(excess(run)[[0, 1, 3, 4, 5]]).max() < 1e-12


def test_a_bias_steps_once() -> None:
    run = noise_free(case_of("bias_step", time=50.0, gyro=[1e-3, 0, 0], accel=[0, 0, 0]))
    assert np.allclose(excess(run)[0], 1e-3 * (run.stamp >= 50.0), atol=1e-9)


def test_a_walk_spreads_with_the_root_of_time() -> None:
    ends = []
    for seed in range(12):
        call = EffectCall(name="bias_random_walk", parameters={"gyro": 1e-5, "accel": 1e-4})
        run = without_noise(Case(seed=seed, procedure="rests", dwell_s=5.0, effects=(call,)))
        ends += list((excess(run)[:, 10000] - excess(run)[:, 0]) / np.repeat([1e-5, 1e-4], 3))
    assert np.std(ends) == pytest.approx(10.0, rel=0.3)


def test_stress_relaxes_after_moves_and_not_after_ramps() -> None:
    run = noise_free(case_of("x_stress_relaxation", accel=[1e-2, 0, 0], tau=2.0))
    at = {
        segment.name: begin
        for segment, begin in zip(run.plan.segments, run.plan.bounds, strict=False)
    }
    start = round(at["position_-y_180"] * 100)
    assert excess(run)[3, start] == pytest.approx(1e-2, rel=1e-6)
    assert excess(run)[3, start + 200] == pytest.approx(1e-2 / np.e, rel=1e-3)
    after_ramp = round(at["rate_x_-50"] * 100)
    assert abs(excess(run)[3, after_ramp]) < 1e-4


def test_the_memory_of_two_moves_ago() -> None:
    run = noise_free(case_of("x_two_moves_ago", share=[1e-3, 0, 0]))
    now = in_segment(run, "position_-x_180")  # before the last rest the unit stood x up
    assert excess(run)[3, now].mean() == pytest.approx(1e-3 * 9.8015, rel=1e-4)
    later = in_segment(run, "position_+y_180")  # before the last rest it stood x down
    assert excess(run)[3, later].mean() == pytest.approx(-1e-3 * 9.8015, rel=1e-4)


def test_cable_drag_shows_at_its_angle_only() -> None:
    run = noise_free(case_of("x_cable_drag", vector=[1e-3, 0, 0], angle=2.0, width=0.25))
    rows = in_segment(run, "rate_z_+50")
    away = np.angle(np.exp(1j * (run.table_angles[0][rows] - 2.0)))
    pulled = np.abs(excess(run)[4, rows])
    assert pulled[np.abs(away) < 0.05].min() > 0.9 * 1e-3 * 9.8
    assert pulled[np.abs(away) > 1.2].max() < 1e-4 * 1e-3 * 9.8 + 2e-6


@pytest.mark.parametrize("name", sorted({*CATALOGUE, *OUTSIDE} - {"gravity_value"}))
def test_every_effect_says_what_it_is_and_changes_what_is_recorded(name: str) -> None:
    run = noise_free(case_of(name, fields={"rate_hz": 25}))
    assert set(run.effects[0].parameters) == set(EFFECTS[name].units)
    assert json.dumps(dict(run.effects[0].parameters))
    assert np.isfinite(run.truth).all()
    assert np.abs(excess(run)).max() > 1e-6


def test_the_catalogue_is_whole_and_what_is_outside_is_marked() -> None:
    assert len(CATALOGUE) == 37
    assert len(OUTSIDE) >= 12


def test_a_case_that_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match="no effect ghost"):
        without_noise(case_of("ghost"))
    with pytest.raises(ValueError, match="several axes"):
        without_noise(case_of("axis_nonorthogonality", fields={"procedure": "single_axis"}))
    with pytest.raises(ValueError, match="stands twice"):
        without_noise(case_of("bias_step", "bias_step"))
    with pytest.raises(ValueError, match="no parameter wrong"):
        without_noise(case_of("bias_step", wrong=1.0))
