"""Errors of the reference, estimated from itself, against what was put into it."""

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tasks.motion.pose import derivative_gain, derivatives
from tasks.motion.reference_noise import reference_noise
from tasks.motion.whole import whole_motion
from tests.moved_by_hand import poses, recording
from tests.on_shaft import shaft_manifest

T = np.arange(0.0, 60.0, 0.01)
TURNING = (T > 20.0) & (T < 40.0)
WIDTH = 0.04  # s


def shaft(angle: np.ndarray) -> Recording:
    """About a level axis, by an encoder."""
    return Recording(shaft_manifest(1, 0, 0), Stream(T, {}), table=Stream(T, {"a_angle": angle}))


def swing() -> np.ndarray:
    """At rest, then two swings of about 2 s, then at rest."""
    moved = 0.8 * np.sin(2.0 * np.pi * 0.45 * (T - 20.0)) ** 3
    return np.where(TURNING, moved, moved[TURNING][-1] * (T >= 40.0))


def deviation(run: Recording) -> np.ndarray:
    motion = whole_motion(run)
    return np.sqrt(reference_noise(run, motion).variance(motion, WIDTH))


def test_the_noise_of_an_encoder_becomes_that_of_mean_rates():
    noise = 1e-4 * np.random.default_rng(5).standard_normal(len(T))
    turning = swing() + 0.3 * T  # a rest has one error
    run, exact = shaft(turning + noise), whole_motion(shaft(turning))
    error = (whole_motion(run).rate - exact.rate)[T < 19.0, 0]
    means = error[: len(error) // 4 * 4].reshape(-1, 4).mean(axis=1)
    expected = deviation(run)[T < 19.0, 0]
    assert means.std() == pytest.approx(np.sqrt((expected**2).mean()), rel=0.4)


def carried(inner_angle: np.ndarray) -> Recording:
    """An axis that rests, at right angles on one that turns at 2 rad/s."""
    manifest = shaft_manifest(0, 0, 1)
    outer = (manifest.station.table_axes or ())[0]
    inner = outer.model_copy(update={"name": "b", "direction": (1.0, 0.0, 0.0)})
    station = manifest.station.model_copy(update={"table_axes": (outer, inner)})
    manifest = manifest.model_copy(update={"station": station})
    table = Stream(T, {"a_angle": 2.0 * T, "b_angle": inner_angle})
    return Recording(manifest, Stream(T, {}), table=table)


def test_the_noise_of_an_inner_axis_turns_the_rate_of_the_outer_one():
    run = carried(2e-3 * np.random.default_rng(8).standard_normal(len(T)))
    motion = whole_motion(run)
    expected = np.sqrt(reference_noise(run, motion).variance(motion, T[1]))
    inside = (T > 5.0) & (T < 55.0)
    assert motion.rate[inside, 1].std() == pytest.approx(2.0 * 2e-3, rel=0.05)
    assert expected[inside, 1].mean() == pytest.approx(2.0 * 2e-3, rel=0.2)
    assert expected[inside, 2].mean() < 1e-3


@pytest.mark.parametrize(("noise", "share"), [(0.02, 1.0), (0.5, 0.0)])
def test_a_rest_of_an_inner_axis_has_one_rounding_unless_noise_moves_its_code(noise, share):
    step, width = 4e-3, 10.0
    errors = noise * np.random.default_rng(9).standard_normal(len(T))
    moved = 0.2 + 0.2 * np.clip(T - 30.0, 0.0, 2.0)
    run = carried(step * np.round(moved / step + errors))
    motion = whole_motion(run)
    expected = np.sqrt(reference_noise(run, motion).variance(motion, width))[(T > 5.0) & (T < 25.0)]
    assert np.median(expected[:, 1]) == pytest.approx(share * 2.0 * step / np.sqrt(12.0), abs=4e-4)


def test_a_coarse_encoder_is_exact_at_rest_and_uncertain_while_it_turns():
    step = np.radians(0.2)
    coarse = deviation(shaft(np.round(swing() / step) * step))[:, 0]
    assert coarse[T < 18.0].max() == 0.0
    assert np.median(coarse[TURNING]) > 0.3 * step / np.sqrt(12.0) / WIDTH


def test_the_noise_of_frames_becomes_that_of_rates_and_accelerations():
    interval, edge = 1.0 / 120.0, 6.0
    noise = np.random.default_rng(5).standard_normal((20_000, 3))
    for order, found in enumerate(derivatives(noise, interval, edge)):
        variance = derivative_gain(order, edge, interval)
        assert found[100:-100].var() == pytest.approx(variance, rel=0.1)


def test_the_noise_of_poses_is_read_off_what_their_smoothing_takes_away():
    motion = whole_motion(recording(reference=poses(4, 2e-4, 1e-4)))
    tracking = motion.tracking
    assert np.sqrt(tracking.attitude_variance) == pytest.approx(2e-4, rel=0.2)
    assert 0.8e-4 < np.sqrt(tracking.place_variance) < 1.6e-4  # with some lost motion
    variance = reference_noise(recording(), motion).variance(motion, WIDTH)
    assert variance[0, 0] == pytest.approx(tracking.rate_variance(WIDTH))
    assert variance[0, 3] == pytest.approx(tracking.force_variance(WIDTH, motion.gravity))


def test_a_single_step_of_a_coarse_encoder_is_no_turn_of_a_rest():
    step = 1e-3
    single = step * ((T > 9.0) & (T < 9.5))
    run = shaft(np.round(swing() / step) * step + single)
    wrong = np.abs(whole_motion(run).rate[:, 0] * (T < 18.0))
    assert 0.0 < wrong.max() < 0.1 * step / 0.01
    assert (wrong > 8.0 * deviation(run)[:, 0] + 1e-9).mean() < 0.01


def test_stamps_that_scatter_make_noise_of_the_turn():
    """The encoder is read at even times."""
    jitter = 1e-3
    run = shaft(swing())
    stamps = np.sort(T + jitter * np.random.default_rng(2).standard_normal(len(T)))
    scattered = Recording(run.manifest, run.imu, table=Stream(stamps, run.table.columns))
    error = (whole_motion(scattered).rate - whole_motion(run).rate)[:, 0]
    means = error[: len(error) // 4 * 4].reshape(-1, 4).mean(axis=1)
    fast = np.abs(whole_motion(run).rate[::4, 0]) > 1.0
    expected = deviation(scattered)[::4, 0][fast]
    assert means[fast].std() == pytest.approx(np.sqrt((expected**2).mean()), rel=0.5)
    assert deviation(scattered)[T < 18.0, 0].max() < 1e-6
