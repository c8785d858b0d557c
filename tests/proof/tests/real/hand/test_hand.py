"""The hand analyses find what made-up data hold, and nothing in noise."""

from collections.abc import Callable

import numpy as np
import pytest

from schemas.recording import Recording
from tests.proof.real.hand.measured import Measured, amplitude, batch_mean, prominence, strongest
from tests.proof.real.hand.rests import half_difference, means_of, misfit, wander
from tests.proof.real.hand.shaft import (
    delay_by_angle,
    delay_by_gravity,
    delay_by_pattern,
    delay_by_phase,
    jump_at,
    line_shared,
    scale_by_gravity,
    slip_at,
)
from tests.proof.real.hide import Size, lost_samples, scaled_table

LATE = 0.008  # s, see conftest


@pytest.mark.parametrize(
    "way", [delay_by_angle, delay_by_phase, delay_by_gravity, delay_by_pattern]
)
def test_four_ways_find_one_delay(way: Callable[[Recording], Measured], shaft: Recording) -> None:
    found = way(shaft)
    assert found.value == pytest.approx(LATE, abs=max(2.5 * found.u, 2e-4))
    assert found.u < 1e-3


def test_lost_samples_are_a_slip_of_their_length(shaft: Recording) -> None:
    lost = lost_samples(shaft, Size(5.0, "1", at=30.0))
    assert slip_at(lost, 30.0).value == pytest.approx(0.05, abs=0.002)
    assert slip_at(shaft, 30.0).value == pytest.approx(0.0, abs=0.002)


def test_gravity_tells_the_encoders_scale(shaft: Recording) -> None:
    more = scale_by_gravity(scaled_table(shaft, Size(0.01, "1")))
    assert more.value - scale_by_gravity(shaft).value == pytest.approx(0.01, abs=2e-4)


def test_motion_that_the_encoder_sees_is_shared(shaft: Recording) -> None:
    at, coherence = line_shared(shaft)
    assert at == pytest.approx(12.8, abs=0.02)
    assert coherence > 0.95


def test_steady_channel_does_not_jump(shaft: Recording) -> None:
    jump = jump_at(shaft, "gyro_z", 32.0)
    assert abs(jump.value) < 4.0 * jump.u


def test_line_has_its_amplitude_and_noise_has_none() -> None:
    rng = np.random.default_rng(1)
    t = np.arange(0.0, 60.0, 0.02)
    y = rng.normal(0.0, 1.0, len(t))
    assert prominence(t, y, 7.0) < 3.3
    loud = y + 0.5 * np.sin(2.0 * np.pi * 7.0 * t)
    assert amplitude(t, loud, 7.0) == pytest.approx(0.5, abs=0.1)
    assert prominence(t, loud, 7.0) > 5.0
    assert strongest(t, loud, 5.0, 9.0) == pytest.approx(7.0, abs=0.01)


def test_mean_of_batches_knows_slow_noise() -> None:
    slow = np.cumsum(np.random.default_rng(2).normal(size=4000))
    assert batch_mean(slow, 10)[1] > 5.0 * slow.std() / np.sqrt(len(slow))


def test_rests_of_an_ideal_unit_have_no_misfit(ideal_run: Callable[..., Recording]) -> None:
    directions, means = means_of(ideal_run(dwell=10.0))
    assert np.abs(misfit(directions, means)).max() < 1e-8


def test_half_difference_is_what_follows_gravity(ideal_run: Callable[..., Recording]) -> None:
    g_sensitive = np.zeros((3, 3))
    g_sensitive[0, 0] = 1e-5  # (rad/s)/(m/s2)
    recording = ideal_run(dwell=10.0, G=g_sensitive)
    two = ("position_+x_000", "position_-x_000")
    segments = tuple(s for s in recording.manifest.segments or () if s.name in two)
    manifest = recording.manifest.model_copy(update={"segments": segments})
    observation = half_difference(Recording(manifest, recording.imu), 0)
    gravity = recording.manifest.station.gravity_m_s2
    assert gravity is not None
    assert observation.value == pytest.approx(np.degrees(1e-5 * gravity) * 3600.0, rel=1e-3)


def test_walk_is_told_from_rests_that_were_placed_anew(
    ideal_run: Callable[..., Recording],
) -> None:
    rng = np.random.default_rng(3)
    still = ideal_run(dwell=30.0, noise=0.0)

    def with_series(series: np.ndarray) -> Recording:
        noisy = series + rng.normal(0.0, 0.01, len(series))
        columns = dict(still.imu.columns) | {"accel_x": still.imu.columns["accel_x"] + noisy}
        return Recording(still.manifest, type(still.imu)(still.imu.t, columns))

    count = len(still.imu)
    walk = np.cumsum(rng.normal(0.0, 0.01, count))
    assert wander(with_series(walk), (3,)).verdict == "true"
    placed = np.repeat(rng.normal(0.0, 0.05, count // 300), 300)
    assert wander(with_series(placed), (3,)).verdict == "false"
    assert wander(with_series(np.zeros(count)), (3,)).verdict == "cannot tell"
