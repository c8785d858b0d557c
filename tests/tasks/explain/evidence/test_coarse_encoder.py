"""What errors of the reference decide is left open."""

import numpy as np
import pytest
from scipy.signal import bilinear, lfilter

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.explain.explain import explain
from tasks.explain.explanation import Finding
from tests.on_shaft import shaft_manifest

RATE_HZ, ENCODER_HZ, FINE_HZ, SECONDS = 200, 250, 2000, 25
COARSE_RAD, SMOOTH_RAD, G = 4e-3, 1e-6, 9.8
T = np.arange(SECONDS * FINE_HZ) / FINE_HZ
RAMPS = np.interp(T % 5.0, [0.0, 1.0, 1.3, 2.2, 2.8, 3.7, 4.0, 5.0],
                  [0.0, 0.0, 2.6, 2.6, -2.6, -2.6, 0.0, 0.0])  # fmt: skip
SWINGS = 2.6 * np.sin(2.0 * np.pi * T) ** 3  # without corners


def turning(
    *, filtered: bool, step: float, corner_hz: float = 60.0, rate: np.ndarray = RAMPS,
    level: bool = False,
) -> Recording:  # fmt: skip
    """To and fro on a shaft; read through a second-order filter or as late as that makes it.

    step: rad, of the encoder; the stamps of a coarse one scatter by 0.8 ms. level: the shaft is,
    so that accelerometers feel the turn as well.
    """
    rng = np.random.default_rng(4)
    w = 2.0 * np.pi * corner_hz
    delay = np.sqrt(2.0) / w
    low_pass = bilinear([w**2], [1.0, np.sqrt(2.0) * w, w**2], FINE_HZ)
    turned = np.cumsum(rate) / FINE_HZ
    force = (np.sin(turned), np.cos(turned)) if level else (0.0 * turned, 0.0 * turned + 1.0)
    late = [
        lfilter(*low_pass, one) if filtered else np.interp(T - delay, T, one)
        for one in (rate, *force)
    ]
    seen, across, up = (one[:: FINE_HZ // RATE_HZ] for one in late)
    t = T[:: FINE_HZ // RATE_HZ]
    gyro = 5e-3 * rng.standard_normal((3, len(t)))
    gyro[0 if level else 2] += seen
    accel = 2e-2 * rng.standard_normal((3, len(t))) + G * np.array([0.0 * up, across, up])
    stamps = np.arange(0.0, SECONDS, 1.0 / ENCODER_HZ)
    when = stamps + (8e-4 if step == COARSE_RAD else 0.0) * rng.standard_normal(len(stamps))
    angle = np.interp(when, T, turned)
    table = Stream(stamps, {"a_angle": step * np.round(angle / step)})
    imu = Stream(t, dict(zip(GYRO + ACCEL, [*gyro, *accel], strict=True)))
    return Recording(shaft_manifest(*((1, 0, 0) if level else (0, 0, 1))), imu, table=table)


def named(recording: Recording) -> list[Finding]:
    findings = explain(recording).findings
    return [one for one in findings if one.terms and one.effect != "unnamed"]


def names(finding: Finding) -> set[str]:
    return {finding.effect, *finding.group, *finding.indistinguishable}


@pytest.mark.rehearsal
@pytest.mark.parametrize(
    ("step", "filtered"),
    [
        (COARSE_RAD, True),
        pytest.param(COARSE_RAD, False, marks=pytest.mark.rehearsal),
        (SMOOTH_RAD, True),
    ],
)
def test_a_fast_filter_and_a_delay_are_not_told_apart_at_sharp_ramps(
    step: float, *, filtered: bool
) -> None:
    """An encoder that reads corners between its samples errs by more than the two differ."""
    (finding,) = named(turning(filtered=filtered, step=step, level=True))
    assert names(finding) >= {"time_offset", "bandwidth"}


@pytest.mark.rehearsal
@pytest.mark.parametrize("filtered", [True, False])
def test_what_one_gyro_alone_shows_has_no_single_name(*, filtered: bool) -> None:
    """Nor has it by a fine encoder: its reading of corners between two samples decides."""
    (finding,) = named(turning(filtered=filtered, step=SMOOTH_RAD))
    assert names(finding) >= {"time_offset", "bandwidth"}


def test_a_fine_encoder_tells_a_slow_filter_from_a_delay() -> None:
    recording = turning(filtered=True, step=SMOOTH_RAD, corner_hz=6.0, rate=SWINGS)
    assert [names(one) for one in named(recording)] == [{"bandwidth"}]
