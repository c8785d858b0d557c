"""A low-pass that only quietens the encoder is told from one that the unit has."""

from dataclasses import replace
from typing import cast

import numpy as np
import pytest
from scipy.signal import lfilter

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.explain.evidence.evidence import Evidence
from tasks.explain.evidence.reference_errors import (
    dither,
    made_by_chance,
    simulated_reading,
)
from tasks.explain.explain import explain
from tasks.explain.inputs.full_rate import full_rate
from tests.on_shaft import shaft_manifest

T = np.arange(0.0, 60.0, 0.01)
SEED = 7
ANGLE = 0.3 * np.sin(2.0 * np.pi * 0.25 * T) ** 3 * (T > 20.0)


def shaft(encoder_noise: float, low_pass: float = np.inf) -> Recording:
    """On a shaft whose encoder errs by so many rad; its rates pass a filter of so many Hz."""
    rng = np.random.default_rng(6)
    gyro = 1e-4 * rng.standard_normal((3, len(T)))
    kept = np.exp(-2.0 * np.pi * low_pass * (T[1] - T[0]))
    gyro[2] += lfilter([1.0 - kept], [1.0, -kept], np.gradient(ANGLE, T))
    accel = 1e-3 * rng.standard_normal((3, len(T))) + np.array([[0.0], [0.0], [9.8]])
    imu = Stream(T, dict(zip(GYRO + ACCEL, [*gyro, *accel], strict=True)))
    read = ANGLE + encoder_noise * rng.standard_normal(len(T))
    return Recording(shaft_manifest(0, 0, 1), imu, table=Stream(T, {"a_angle": read}))


@pytest.mark.parametrize("encoder_noise", [0.0, 1e-5])
def test_a_low_pass_of_the_unit_stands(encoder_noise: float) -> None:
    findings = explain(shaft(encoder_noise, low_pass=5.0), only=("bandwidth",)).findings
    assert "bandwidth" in [one.effect for one in findings if one.refusal is None]


def test_what_only_quietens_the_encoder_has_no_name() -> None:
    named = [one.effect for one in explain(shaft(3e-3)).findings]
    assert set(named) <= {"unnamed"}


def test_a_simulated_reading_errs_as_much_as_the_encoder() -> None:
    recording = shaft(1e-3)
    full = full_rate(recording)
    simulated = simulated_reading(recording, full, np.random.default_rng(SEED))
    assert simulated is not None
    true, read = simulated
    resting = (T > 1.0) & (T < 19.0)
    error = (read.rate - true.rate)[resting, 2].std()
    assert 0.5 < error / full.motion.rate[resting, 2].std() < 2.0


def test_rounding_shifts_a_rest_as_a_whole_though_nothing_scatters() -> None:
    recording, step = shaft(0.0), 2e-3
    angle = np.interp(T, [20.0, 25.0, 40.0, 45.0], [0.0, 1.5, 1.5, 2.6])
    rounded = Stream(T, {"a_angle": step * np.round(angle / step)})
    recording = replace(recording, table=rounded)
    full = full_rate(recording)
    axes = [
        one.axes
        for one in simulated_reading(recording, full, np.random.default_rng(SEED)) or ()
        if one.axes
    ]
    error = axes[1].angles[:, 0] - axes[0].angles[:, 0]
    rests = [error[(first < T) & (last > T)] for first, last in ((2, 18), (27, 38), (47, 58))]
    assert max(np.ptp(one) for one in rests) < 1e-6
    means = np.array([one.mean() for one in rests])
    assert np.abs(means).max() < 0.51 * step
    assert np.ptp(means) > 0.02 * step


class NineParameters:
    """Evidence of one finding: so much, of which its nine parameters cost 20."""

    own = ((list(range(9)), np.zeros(9)),)

    def __init__(self, size: float) -> None:
        self.size = size

    def gain(self, number: int) -> float:
        return self.size

    def evidence(self, number: int) -> float:
        return self.size

    def delta_bic(self, number: int) -> float:
        return self.size - 20.0


@pytest.mark.parametrize(
    ("size", "gain", "draws", "chance"),
    [
        (70.0, 0.0, 4, False),
        (70.0, 15.0, 4, True),  # the errors of the reference make the noise 2.8 times larger
        (900.0, 15.0, 4, False),
        (900.0, 300.0, 4, True),
        (80.0, 12.0, 1, True),  # one draw tells little of how large the next would be
        (80.0, 12.0, 16, False),
    ],
)
def test_evidence_is_counted_against_what_the_reference_makes_by_chance(
    size: float, gain: float, draws: int, *, chance: bool
) -> None:
    evidence = cast("Evidence", NineParameters(size))
    assert made_by_chance(evidence, 0, gain * draws, draws) is chance


def test_encoders_that_stand_still_have_no_errors_to_simulate() -> None:
    recording = shaft(0.0)
    recording = replace(recording, table=Stream(T, {"a_angle": np.zeros(len(T))}))
    assert simulated_reading(recording, full_rate(recording), np.random.default_rng(SEED)) is None


@pytest.mark.parametrize("ratio", [0.0, 0.2, 0.4, 1.5])
def test_the_noise_before_rounding_is_told_by_how_rests_scatter(ratio: float) -> None:
    step, rng = 1e-3, np.random.default_rng(8)
    rests = np.repeat(rng.uniform(0.0, 1.0, 600), 60)
    read = step * np.round(rests / step + ratio * rng.standard_normal(len(rests)))
    level = np.diff(rests, append=rests[-1]) == 0.0
    at_rest = np.convolve(~level, np.ones(13), "same") == 0
    assert dither(read, at_rest, step) / step == pytest.approx(ratio, abs=0.05)


def test_an_arm_that_a_coarse_encoder_makes_too_long_has_the_u_of_that() -> None:
    """Ramps of half a second are rounded off by a window as long."""
    rate = np.interp(T % 5.0, [0.0, 2.0, 2.5, 4.5, 5.0], [0.0, 0.0, 1.0, 1.0, 0.0])
    bend, arm = np.gradient(rate, T), 0.006
    rng = np.random.default_rng(8)
    gyro = 1e-4 * rng.standard_normal((3, len(T)))
    gyro[2] += rate
    accel = 1e-3 * rng.standard_normal((3, len(T))) + np.array([[0.0], [0.0], [9.8]])
    accel[0] -= rate**2 * arm
    accel[1] += bend * arm
    angle = np.cumsum(rate) * T[1]
    imu = Stream(T, dict(zip(GYRO + ACCEL, [*gyro, *accel], strict=True)))
    u = []
    for step in (1e-7, 1e-3):
        table = Stream(T[::2], {"a_angle": step * np.round(angle[::2] / step)})
        recording = Recording(shaft_manifest(0, 0, 1), imu, table=table)
        found = explain(recording, only=("lever_arm",)).by_name["lever_arm"]
        r_x = next(each for each in found.parameters if each.name == "r_x")
        assert abs(r_x.value - arm) < 2.0 * r_x.u
        u.append(r_x.u)
    assert u[1] > 0.02 * arm
    assert u[1] > 3.0 * u[0]
