"""Derivatives of an encoder's angle."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from schemas.recording import ANGLE, GYRO, Recording, Stream
from tasks.explain.explanation import CHANNELS
from tasks.motion.encoders import (
    EncoderRate,
    Rest,
    as_mean_rates,
    encoder_rate,
    lost_acceleration,
    rests,
    smooth_course,
    smooth_derivatives,
)
from tests.manifests import manifest_of
from tests.on_shaft import shaft_manifest

T = np.arange(0.0, 10.0, 0.01)


def swing(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return np.sin(2 * t), 2 * np.cos(2 * t), -4 * np.sin(2 * t)


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 1000.0])
def test_derivatives_of_a_swing(rate_hz):
    t = np.arange(0.0, 10.0, 1 / rate_hz)
    found = smooth_derivatives(t, swing(t)[0][:, None], T[100:-100])
    for observed, true in zip(found, swing(T[100:-100]), strict=True):
        assert observed[:, 0] == pytest.approx(true, abs=0.02)


def test_the_noise_of_the_encoder_does_not_become_acceleration():
    noise = 5e-6 * np.random.default_rng(4).standard_normal(len(T))
    angle = (0.3 * T**2 + noise)[:, None]
    _, _, acceleration = smooth_derivatives(T, angle, T[100:-100])
    assert acceleration.mean() == pytest.approx(0.6, abs=1e-3)
    assert acceleration.std() < 0.02
    assert np.diff(angle[:, 0], 2).std() / 0.01**2 > 0.1  # what it would be without a window


def test_ramps_keep_their_sharp_ends():
    rate = np.clip(2.0 * (T - 3.0), 0.0, 5.0)
    angle = np.cumsum(rate) * 0.01
    _, _, acceleration = smooth_derivatives(T, angle[:, None], T)
    true = np.where((T > 3.0) & (T < 5.5), 2.0, 0.0)
    gain = acceleration[:, 0] @ true / (acceleration[:, 0] @ acceleration[:, 0])
    assert gain == pytest.approx(1.0, abs=0.01)


def test_nothing_is_known_in_a_gap_of_the_samples():
    kept = (T < 4.0) | (T > 6.0)
    found = smooth_derivatives(T[kept], swing(T[kept])[0][:, None], np.array([2.0, 5.0, 8.0, 11.0]))
    for each in found:
        assert np.isfinite(each[:, 0]).tolist() == [True, False, True, False]


def test_no_derivative_is_made_of_a_line_drawn_over_a_gap():
    kept = (T < 4.0) | (T > 4.08)  # short enough for the angle to be known all through
    angle, rate, acceleration = smooth_derivatives(T[kept], swing(T[kept])[0][:, None], T[100:-100])
    assert np.isfinite(angle).all()
    for found, true in ((rate, 2 * np.cos(2 * T)), (acceleration, -4 * np.sin(2 * T))):
        known = np.isfinite(found[:, 0])
        assert 10 <= (~known).sum() <= 20
        assert found[known, 0] == pytest.approx(true[100:-100][known], abs=0.02)


def test_a_fast_oscillation_is_as_large_between_the_samples_as_at_them():
    """Else every unit whose clock is late would seem to amplify, as one that has a lead does."""
    pulse = 2 * np.pi * 3.0
    middles = T[100:-100] + 0.005
    _, rate, _ = smooth_derivatives(T, np.sin(pulse * T)[:, None], middles)
    assert rate[:, 0] == pytest.approx(pulse * np.cos(pulse * middles), abs=3e-3 * pulse)


def test_the_rate_of_a_quiet_encoder_is_not_rounded_on_a_smooth_ramp():
    rate = 2.5 * (1.0 - np.cos(np.pi * T / 2.0))
    angle = (2.5 * (T - 2.0 / np.pi * np.sin(np.pi * T / 2.0)))[:, None]
    inner = T[100:-100]
    _, quiet, _ = smooth_derivatives(T, angle, inner)
    assert quiet[:, 0] == pytest.approx(rate[100:-100], abs=1e-6)
    noise = 1e-4 * np.random.default_rng(6).standard_normal(angle.shape)
    _, noisy, _ = smooth_derivatives(T, angle + noise, inner)
    assert (noisy[:, 0] - rate[100:-100]).std() < 0.5 * 0.95 * 1e-4 / 0.01  # not the quartic's


def test_a_coarse_encoder_does_not_damp_a_shaft_that_shakes():
    """A stepper's resonance of 13 Hz, ten times the encoder's step: a parabola takes a third."""
    angle = 0.006 * np.sin(2 * np.pi * 13.0 * T)
    rate = 0.006 * 2 * np.pi * 13.0 * np.cos(2 * np.pi * 13.0 * T)[100:-100]
    coarse = (0.0015 * np.round(angle / 0.0015))[:, None]
    _, found, _ = smooth_derivatives(T, coarse, T[100:-100])
    assert found[:, 0] @ rate / (rate @ rate) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("interval", [0.01 - 1e-14, 0.01, 0.01 + 1e-14])
def test_the_last_digit_of_a_stamp_chooses_no_window(interval):
    t = interval * np.arange(1000)
    _, rate, _ = smooth_derivatives(t, swing(t)[0][:, None], t[100:-100])
    _, at_once, _ = smooth_derivatives(T, swing(T)[0][:, None], T[100:-100])
    assert rate == pytest.approx(at_once, abs=1e-9)


# Rates of coarse encoders, against the motion that was read.

T_ENCODER_RATE = np.arange(0.0, 60.0, 0.01)
NOISE = 1e-3  # rad
RAMP = np.clip((T_ENCODER_RATE - 20.0) / 1.5, 0.0, 1.0) - np.clip(
    (T_ENCODER_RATE - 40.0) / 1.5, 0.0, 1.0
)
TRUE = 2.5 * RAMP  # rad/s: at rest, up a ramp, held, down again, at rest
CORNERS = np.min([np.abs(T_ENCODER_RATE - t) for t in (20.0, 21.5, 40.0, 41.5)], axis=0)


def found(noise: float) -> EncoderRate:
    turned = cumulative_trapezoid(TRUE, T_ENCODER_RATE, initial=0.0)
    angle = turned + noise * np.random.default_rng(7).standard_normal(len(T_ENCODER_RATE))
    return encoder_rate(angle[:, None], 0.01, np.full((len(T_ENCODER_RATE), 1), noise**2))


def errors(of: EncoderRate) -> np.ndarray:
    return of.rate[:, 0] - TRUE


def test_a_coarse_encoder_is_smoothed_by_as_much_as_rests_and_held_rates_bear():
    of = found(NOISE)
    steady = (CORNERS > 3.0) & (T_ENCODER_RATE > 1.0) & (T_ENCODER_RATE < 59.0)
    shortest = NOISE * np.linalg.norm(of.kernels[0]) / 0.01
    assert errors(of)[steady].std() < 0.02 * shortest


def test_the_ends_of_a_ramp_are_not_rounded_off():
    of = found(NOISE)
    near = CORNERS < 0.5
    assert np.sqrt((errors(of)[near] ** 2 / of.variance[near, 0]).mean()) < 1.5
    assert np.abs(errors(of)).max() < 0.25  # half a second of smoothing would round off 0.4


def test_the_variance_is_that_of_the_errors_and_of_their_means():
    of = found(NOISE)
    turning = ~of.at_rest[:, 0]  # each rest has one error
    ratio = errors(of)[turning] ** 2 / of.variance[turning, 0]
    assert np.median(ratio) == pytest.approx(0.45, rel=0.7)
    whole = turning.reshape(-1, 50).all(axis=1)
    means = errors(of).reshape(-1, 50).mean(axis=1)[whole]
    expected = of.variance_of_mean(0.5)[:, 0].reshape(-1, 50).mean(axis=1)[whole]
    assert np.sqrt((means**2).mean()) == pytest.approx(np.sqrt(expected.mean()), rel=0.5)


def test_a_fine_encoder_keeps_the_shortest_window():
    of = found(1e-9)
    assert len(of.kernels) == 1
    assert np.abs(errors(of)[CORNERS > 0.1]).max() < 0.01


def test_a_rest_has_one_rate_whose_mean_is_no_less_uncertain():
    of = found(NOISE)
    rest = of.at_rest[:, 0] & (T_ENCODER_RATE < 20.0)
    assert rest.mean() > 0.3
    assert np.ptp(of.rate[rest]) == 0.0
    assert of.variance_of_mean(0.5)[rest] == pytest.approx(of.variance[rest])


def test_a_rest_of_which_an_encoder_gives_one_sample_has_no_rate_of_its_own():
    """Read once in four seconds; of the rests in between smoothing leaves the middle alone."""
    angle = np.repeat([0.0, 0.5, 1.0, 1.5], 11)
    found = list(rests(angle, 4.0, np.full(len(angle), 1e-12)))
    assert [(rest.first, rest.last) for rest in found] == [(0, 3), (36, 44)]


# Rests of a noisy encoder, against the motion that was read.

T_RESTS = np.arange(0.0, 30.0, 0.01)
RAMPS = np.clip(T_RESTS - 10.0, 0.0, 1.0) - np.clip(
    T_RESTS - 14.0, 0.0, 1.0
)  # up in 1 s, held, down in 1 s


def found_rests(rate: np.ndarray, seed: int = 3, step: float = 0.0) -> list[Rest]:
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(T_RESTS))
    angle = cumulative_trapezoid(rate, T_RESTS, initial=0.0) + noise
    if step:
        angle = step * np.round(angle / step)
    variance = np.full(len(T_RESTS), NOISE**2 + step**2 / 12.0)
    return list(rests(angle, 0.01, variance))


def test_the_stretches_before_and_after_a_turn_are_rests_up_to_its_corners():
    for seed in range(10):
        before, after = found_rests(RAMPS, seed)
        assert before.first < 10
        assert after.last == len(T_RESTS)
        assert 9.5 < T_RESTS[before.last - 1] < 10.06
        assert 14.94 < T_RESTS[after.first] < 15.5


@pytest.mark.parametrize("step", [0.0, 2e-3])
def test_the_rate_of_a_rest_is_as_uncertain_as_it_errs(step):
    drift = 2e-5 * np.ones_like(T_RESTS)
    errors = [
        (one.rate - 2e-5) / one.u for seed in range(40) for one in found_rests(drift, seed, step)
    ]
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(1.0, abs=0.3)


def test_a_rate_that_is_held_and_one_that_swings_are_no_rests():
    assert not found_rests(np.full_like(T_RESTS, 0.02))
    assert not found_rests(0.05 * np.sin(2.0 * np.pi * 0.2 * T_RESTS))
    assert not found_rests(
        0.3 * np.sin(2.0 * np.pi * 13.0 * T_RESTS), step=5e-4
    )  # a stepper's resonance


# Angles of an AHRS as mean rates: each interval's gain, and nothing where it cannot be told.

T_ANGLE_RATES = np.arange(0.0, 20.0, 0.1)
MANIFEST = manifest_of("ahrs")


def ahrs(angle: np.ndarray, t: np.ndarray = T_ANGLE_RATES) -> Recording:
    columns = dict(zip(ANGLE, np.outer(np.array([1.0, -0.5, 0.0]), angle), strict=True))
    return Recording(MANIFEST, Stream(t, columns | {"accel_z": 9.8 + t}))


def test_rates_are_what_each_interval_gained_and_stand_in_its_middle():
    rates = as_mean_rates(ahrs(0.1 * T_ANGLE_RATES**2)).imu
    assert rates.span == pytest.approx(0.1)
    assert rates.t == pytest.approx(T_ANGLE_RATES[:-1] + 0.05)
    assert rates.columns["gyro_x"] == pytest.approx(0.2 * rates.t)
    assert rates.columns["gyro_y"] == pytest.approx(-0.1 * rates.t)
    assert rates.columns["accel_z"] == pytest.approx(9.8 + rates.t)
    assert not set(ANGLE) & set(rates.columns)


def test_nothing_is_told_where_angles_began_anew_or_samples_were_lost():
    restarted = as_mean_rates(
        ahrs(np.where(T_ANGLE_RATES < 9.95, 50.0 + T_ANGLE_RATES, T_ANGLE_RATES - 10.0))
    ).imu
    assert np.flatnonzero(np.isnan(restarted.columns["gyro_x"])).tolist() == [99]
    kept = np.delete(np.arange(len(T_ANGLE_RATES)), [50, 51])
    lost = as_mean_rates(ahrs(T_ANGLE_RATES[kept], T_ANGLE_RATES[kept])).imu
    assert np.flatnonzero(np.isnan(lost.stack(GYRO)).any(axis=1)).tolist() == [49]


def test_a_unit_that_gives_rates_is_read_by_them():
    recording = ahrs(T_ANGLE_RATES)
    columns = dict.fromkeys(CHANNELS, np.zeros(len(T_ANGLE_RATES)))
    both = Recording(MANIFEST, Stream(T_ANGLE_RATES, {**recording.imu.columns, **columns}))
    assert as_mean_rates(both) is both


# What smoothing takes off the acceleration of a table shows when it is smoothed again.

T_SMOOTHING_ERROR = np.arange(0.0, 40.0, 0.02)
RAMP_SMOOTHING_ERROR, HELD = 0.5, 2.0  # s
TRUE_SMOOTHING_ERROR = np.where(
    T_SMOOTHING_ERROR % (2 * (RAMP_SMOOTHING_ERROR + HELD)) < RAMP_SMOOTHING_ERROR, 2.0, 0.0
)
TRUE_SMOOTHING_ERROR -= np.where(
    (T_SMOOTHING_ERROR - RAMP_SMOOTHING_ERROR - HELD) % (2 * (RAMP_SMOOTHING_ERROR + HELD))
    < RAMP_SMOOTHING_ERROR,
    2.0,
    0.0,
)
ANGLE_SMOOTHING_ERROR = np.cumsum(np.cumsum(TRUE_SMOOTHING_ERROR)) * T_SMOOTHING_ERROR[1] ** 2


def turned(step: float) -> Recording:
    """A shaft that is ramped up and down, read in steps, rad."""
    read = step * np.round(ANGLE_SMOOTHING_ERROR / step) if step else ANGLE_SMOOTHING_ERROR
    imu = Stream(T_SMOOTHING_ERROR, {"gyro_z": np.zeros(len(T_SMOOTHING_ERROR))})
    return Recording(
        shaft_manifest(0, 0, 1), imu, table=Stream(T_SMOOTHING_ERROR, {"a_angle": read})
    )


def test_smoothing_again_takes_about_what_smoothing_took():
    recording = turned(2e-3)
    course = smooth_course(recording.table, ("a_angle",))
    assert course is not None
    found = course.acceleration[:, 0]
    # By how much too large what follows the acceleration is found, by both.
    owed = float(found @ (TRUE_SMOOTHING_ERROR - found) / (found @ found))
    again = float(found @ lost_acceleration(recording, T_SMOOTHING_ERROR)[:, 0] / (found @ found))
    assert owed > 0.05
    assert again == pytest.approx(owed, rel=0.4)


def test_nothing_is_lost_where_no_encoder_is_read():
    recording = turned(0.0)
    assert not lost_acceleration(
        Recording(recording.manifest, recording.imu), T_SMOOTHING_ERROR
    ).any()
