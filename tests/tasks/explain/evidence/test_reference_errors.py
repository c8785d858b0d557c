"""A low-pass that only quietens the encoder is told from one that the unit has."""

import numpy as np
import pytest

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.explain.explain import explain
from tests.on_shaft import T, shaft_manifest, swinging


@pytest.mark.rehearsal
@pytest.mark.parametrize("encoder_noise", [0.0, 1e-5])
def test_a_low_pass_of_the_unit_stands(encoder_noise: float) -> None:
    findings = explain(swinging(encoder_noise, low_pass=5.0), only=("bandwidth",)).findings
    assert "bandwidth" in [one.effect for one in findings if one.refusal is None]


def test_what_only_quietens_the_encoder_has_no_name() -> None:
    named = [one.effect for one in explain(swinging(3e-3)).findings]
    assert set(named) <= {"unnamed"}


@pytest.mark.rehearsal
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
