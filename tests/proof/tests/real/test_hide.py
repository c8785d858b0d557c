"""What is hidden does to the data what the physics would have done, and nothing else."""

from collections.abc import Callable

import numpy as np
import pytest

from schemas.recording import ACCEL, Recording
from tests.proof.real.hide import (
    GRADES,
    TRANSFORMATIONS,
    Size,
    drawn_sizes,
    first_part,
    lost_samples,
    scaled_table,
    shifted_clock,
    tilted_base,
)


def same(one: Recording, other: Recording) -> bool:
    return one.manifest == other.manifest and all(
        np.array_equal(a.t, b.t)
        and all(np.array_equal(a.columns[k], b.columns[k], equal_nan=True) for k in a.columns)
        for a, b in zip(one.streams().values(), other.streams().values(), strict=True)
    )


@pytest.mark.parametrize("name", TRANSFORMATIONS)
def test_size_zero_leaves_the_recording_as_it_is(name: str, shaft: Recording) -> None:
    assert same(TRANSFORMATIONS[name](shaft, Size(0.0, "1", at=3.0)), shaft)


def test_late_clock_moves_the_units_stamps_alone(shaft: Recording) -> None:
    late = shifted_clock(shaft, Size(0.01, "s"))
    np.testing.assert_allclose(late.imu.t - shaft.imu.t, 0.01, atol=1e-9)
    assert late.table is not None
    assert shaft.table is not None
    np.testing.assert_array_equal(late.table.t, shaft.table.t)


def test_scale_is_in_every_angle_that_the_table_tells(shaft: Recording) -> None:
    scaled = scaled_table(shaft, Size(0.002, "1"))
    assert scaled.table is not None
    assert shaft.table is not None
    declared, was = (each.columns["shaft_angle"] for each in (scaled.table, shaft.table))
    np.testing.assert_allclose(declared, 1.002 * was)


def test_without_an_encoder_the_labels_are_scaled(real: Callable[[str], Recording]) -> None:
    scaled = scaled_table(real("ferraris_session"), Size(0.01, "1"))
    turned = [each.angle_deg for each in scaled.manifest.segments or () if each.angle_deg]
    assert turned == pytest.approx([-363.6] * 3)


def test_tilt_of_a_level_axis_is_a_bias_along_it(shaft: Recording) -> None:
    """About North the East-pointing shaft itself leans: its accelerometer reads g·sin of it."""
    tilted = tilted_base(shaft, Size(0.01, "rad"))
    more = np.array([tilted.imu.columns[c] - shaft.imu.columns[c] for c in ACCEL])
    along = np.abs(more[1])  # the unit's y lies along the shaft
    np.testing.assert_allclose(along, 9.80665 * np.sin(0.01), rtol=1e-6)
    assert np.abs(more[[0, 2]]).max() < 9.80665 * (1.0 - np.cos(0.01)) * 1.001


def test_tilt_needs_table_angles(real: Callable[[str], Recording]) -> None:
    with pytest.raises(ValueError, match="table angles"):
        tilted_base(real("ferraris_session"), Size(0.01, "rad"))


def test_lost_samples_leave_no_gap_and_later_ones_slip(shaft: Recording) -> None:
    lost = lost_samples(shaft, Size(5.0, "1", at=10.0))
    assert len(lost.imu) == len(shaft.imu) - 5
    assert np.diff(lost.imu.t).max() < 0.0201
    after = lost.imu.t > 10.1
    np.testing.assert_allclose(
        lost.imu.columns["gyro_y"][after], shaft.imu.columns["gyro_y"][5:][after[: len(lost.imu)]]
    )
    assert shaft.imu.t[-1] - lost.imu.t[-1] == pytest.approx(0.05, abs=0.011)


def test_sizes_are_drawn_from_the_seed_near_their_grades() -> None:
    for name, grades in GRADES.items():
        sizes = drawn_sizes(3, name, 100.0)
        assert sizes == drawn_sizes(3, name, 100.0)
        assert sizes != drawn_sizes(4, name, 100.0)
        assert sizes[0].value == 0.0
        for size, grade in zip(sizes, grades, strict=True):
            assert abs(size.value - grade) <= 0.2 * grade + 1e-12 + 0.5 * (
                name == "dropped_samples"
            )


def test_first_part_ends_in_time(shaft: Recording) -> None:
    part = first_part(shaft, 5.0)
    assert part.table is not None
    assert max(part.imu.t[-1], part.table.t[-1]) < 5.0
