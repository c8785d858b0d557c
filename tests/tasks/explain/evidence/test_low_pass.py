"""A low-pass is told as what it is, or with what it cannot be told from, and with nothing else."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.explain.explain import explain
from tests.on_shaft import shaft_manifest

RATE, FINE = 100.0, 2000.0  # Hz: the output, and what its filter runs at
T = np.arange(0.0, 60.0, 1.0 / RATE)


def angle(t: np.ndarray) -> np.ndarray:
    return np.asarray(0.3 * np.sin(2.0 * np.pi * 0.25 * t) ** 3 * (t > 20.0))


def filtered(order: int, corner: float, encoder_noise: float, delay: float = 0.0) -> Recording:
    """On a shaft: gyros behind a low-pass of so many Hz, stamped s too late."""
    rng = np.random.default_rng(6)
    fine = np.arange(0.0, 60.0, 1.0 / FINE)
    rate = lfilter(*butter(order, corner, fs=FINE), np.gradient(angle(fine - delay), fine))
    gyro = 1e-4 * rng.standard_normal((3, len(T)))
    gyro[2] += rate[:: round(FINE / RATE)]
    accel = 1e-3 * rng.standard_normal((3, len(T))) + np.array([[0.0], [0.0], [9.8]])
    imu = Stream(T, dict(zip(GYRO + ACCEL, [*gyro, *accel], strict=True)))
    read = angle(T) + encoder_noise * rng.standard_normal(len(T))
    return Recording(shaft_manifest(0, 0, 1), imu, table=Stream(T, {"a_angle": read}))


@pytest.mark.parametrize(
    ("order", "corner", "encoder_noise"),
    [
        (1, 40.0, 0.0),
        *(
            pytest.param(order, corner, noise, marks=pytest.mark.rehearsal)
            for order, corner, noise in (
                (1, 5.0, 0.0),
                (1, 5.0, 1e-5),
                (1, 10.0, 0.0),
                (1, 10.0, 1e-5),
                (1, 40.0, 1e-5),
                (2, 10.0, 0.0),
                (2, 10.0, 1e-5),
                (2, 40.0, 0.0),
                (2, 40.0, 1e-5),
            )
        ),
    ],
)
def test_a_low_pass_of_either_order_is_named_alone_or_in_a_group(
    order: int, corner: float, encoder_noise: float
) -> None:
    (found,) = explain(filtered(order, corner, encoder_noise)).findings
    assert "bandwidth" in (found.effect, *found.group)
    if found.effect == "bandwidth":
        constant = "lag" if order == 1 else "time_constant"
        (parameter,) = [one for one in found.parameters if one.name.endswith(constant)]
        assert parameter.value == pytest.approx(1.0 / (2.0 * np.pi * corner), rel=0.02)


@pytest.mark.rehearsal
def test_the_lag_of_a_low_pass_and_a_delay_beside_it_are_told_apart() -> None:
    """As two findings or, where noise has it so, as one of both."""
    findings = explain(filtered(1, 20.0, 1e-5, delay=0.004)).findings
    assert {"bandwidth", "time_offset"} <= {
        name for one in findings for name in (one.effect, *one.group)
    }
    values = {one.name: one.value for finding in findings for one in finding.parameters}
    assert values.keys() == {"gyro_lag", "seconds"}
    assert values["gyro_lag"] == pytest.approx(1.0 / (2.0 * np.pi * 20.0), rel=0.05)
    assert values["seconds"] == pytest.approx(0.004, rel=0.1)


@pytest.mark.rehearsal
def test_a_filter_at_the_rate_of_the_output_that_only_gyros_show_is_explained() -> None:
    recording = filtered(1, 500.0, 0.0)
    assert recording.imu is not None
    kept = np.exp(-2.0 * np.pi * 20.0 / RATE)
    gyro = lfilter([1.0 - kept], [1.0, -kept], recording.imu.columns["gyro_z"])
    imu = Stream(T, {**recording.imu.columns, "gyro_z": gyro})
    findings = explain(Recording(recording.manifest, imu, table=recording.table)).findings
    assert findings[0].effect in ("bandwidth", "time_offset")
