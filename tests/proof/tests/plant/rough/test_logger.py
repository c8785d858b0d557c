"""What firmware and logger do to the rows."""

from collections.abc import Callable

import numpy as np
import pytest

from tests.proof.plant.case import GYRO_NOISE
from tests.proof.tests.plant.rough.short_runs import played, readings, rough_of

STEP = GYRO_NOISE["industrial"].step


@pytest.fixture
def pair() -> Callable[..., tuple[np.ndarray, ...]]:
    """Readings without and with an effect on the log."""

    def build(effect: str, **parameters: object) -> tuple[np.ndarray, ...]:
        with_it = readings(played(rough_of("shaft", effect, **parameters)))
        return readings(played(rough_of("shaft"))), with_it

    return build


def test_range_setting_multiplies_one_triad(pair: Callable[..., tuple[np.ndarray, ...]]) -> None:
    without, written = pair("range_setting", triad="gyro", factor=2.0)
    assert written[:3] == pytest.approx(2.0 * without[:3])
    assert (written[3:] == without[3:]).all()


def test_axis_mapping_exchanges_and_inverts(pair: Callable[..., tuple[np.ndarray, ...]]) -> None:
    without, written = pair("axis_mapping", triads=["accel"], order=[1, 0, 2], sign=[1, 1, -1])
    assert (written[3] == without[4]).all()
    assert (written[4] == without[3]).all()
    assert (written[5] == -without[5]).all()
    assert (written[:3] == without[:3]).all()


def test_dead_zone_writes_small_rates_as_zero(pair: Callable[..., tuple[np.ndarray, ...]]) -> None:
    without, written = pair("dead_zone", threshold=0.02)
    small = np.abs(without[:3]) < 0.02
    assert (written[:3][small] == 0.0).all()
    assert (written[:3][~small] == without[:3][~small]).all()


def test_bias_is_taken_off_at_rest_and_stays_off(
    pair: Callable[..., tuple[np.ndarray, ...]],
) -> None:
    without, written = pair("dead_zone_bias_at_rest", wait=0.5, quiet=0.05, tau=0.3)
    taken = without[:3] - written[:3]
    assert np.abs(written[:3, 300:450].mean(axis=1)).max() < 1e-3
    assert np.abs(without[:3, 300:450].mean(axis=1)).max() > 1e-3
    turning = np.abs(without[0]) > 0.5
    assert np.abs(np.diff(taken, axis=1))[:, turning[1:]].max() < 1e-12


def test_stuck_bit_errs_by_its_weight_or_not_at_all(
    pair: Callable[..., tuple[np.ndarray, ...]],
) -> None:
    without, written = pair("code_fault_stuck_bit", channel=1, bit=6, level=1)
    error = np.rint((written[1] - without[1]) / STEP)
    assert set(np.unique(error)) == {0.0, 64.0}
    assert (np.rint(written[1] / STEP).astype(int) & 64 == 64).all()


def test_torn_code_errs_by_256_counts_where_the_low_byte_wraps(
    pair: Callable[..., tuple[np.ndarray, ...]],
) -> None:
    without, written = pair("code_fault_torn", triad="gyro", share=1.0)
    error = np.rint((written[0] - without[0]) / STEP)
    assert (error % 256 == 0).all()
    assert 0 < (error != 0).mean() < 1.0
    code = np.rint(without[0] / STEP).astype(int)
    wrapped = np.diff(code >> 8, prepend=code[-1] >> 8) != 0
    assert (wrapped == (error != 0)).all()


@pytest.mark.parametrize("form", ["gyro_saturation_plateau", "accel_saturation_plateau"])
def test_a_plateau_behind_the_calibration_is_many_values_and_differs_by_side(
    pair: Callable[..., tuple[np.ndarray, ...]], form: str
) -> None:
    coupling = [[0.0, 0.01, 0.0], [0.0, 0.0, 0.01], [0.01, 0.0, 0.0]]
    limit = 2.0 if form.startswith("gyro") else 7.0
    channel = 0 if form.startswith("gyro") else 4
    offset = [0.05 * limit] * 3
    without, written = pair(form, strength=0.0, limit=limit, offset=offset, coupling=coupling)
    high = written[channel][without[channel] > 1.1 * limit]
    low = written[channel][without[channel] < -1.1 * limit]
    assert len(np.unique(high)) > 10
    assert np.ptp(high) < 0.03 * limit
    assert high.mean() == pytest.approx(0.95 * limit, rel=0.03)
    if channel == 0:
        assert low.mean() == pytest.approx(-1.05 * limit, rel=0.03)


def test_rows_are_held_doubled_or_interpolated(
    pair: Callable[..., tuple[np.ndarray, ...]],
) -> None:
    _, held = pair("repeated_samples_held", rate=0.5)
    assert (held[:, 1::2] == held[:, : 2 * held[:, 1::2].shape[1] : 2]).all()
    without, doubled = pair("repeated_samples_doubled", share=0.2)
    same = (doubled[:, 1:] == doubled[:, :-1]).all(axis=0)
    assert same.mean() == pytest.approx(0.2, abs=0.02)
    assert (doubled[:, 1:][:, ~same] == without[:, 1:][:, ~same]).all()
    without, lines = pair("repeated_samples_interpolated", every=4)
    assert (lines[:, ::4] == without[:, ::4]).all()
    assert lines[0, 2:-4:4] == pytest.approx(
        (lines[0, :-4:4] + lines[0, 4::4])[: len(lines[0, 2:-4:4])] / 2
    )


def test_stamps_scatter_or_close_up_in_batches() -> None:
    plain = played(rough_of("shaft")).recording.imu
    loose = played(rough_of("shaft", "timestamp_jitter", sigma=1e-3)).recording.imu
    assert (loose.t - plain.t).std() == pytest.approx(1e-3, rel=0.05)
    assert (loose.columns["gyro_x"] == plain.columns["gyro_x"]).all()
    batched = played(rough_of("shaft", "timestamp_jitter_batched", batch=5, squeeze=0.8))
    gaps = np.diff(batched.recording.imu.t)
    assert np.median(gaps) == pytest.approx(0.002)
    assert gaps.max() == pytest.approx(0.042, rel=0.01)
    assert (batched.recording.imu.t - plain.t).mean() == pytest.approx(0.0, abs=1e-4)
