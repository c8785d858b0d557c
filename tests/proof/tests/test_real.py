"""A shaft by plain algebra: a unit that swings to and fro beside its encoder."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from schemas.recording import ACCEL, Recording, Stream
from tests.manifests import manifest_of
from tests.moved_by_hand import poses, readings, recording, tilted
from tests.proof.real.hand.measured import Measured, amplitude, batch_mean, prominence, strongest
from tests.proof.real.hand.poses import by_poses
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
from tests.proof.real.hidden import NOT_HIDDEN, Hidden, Score, as_data, hidden_cases, scored
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
from tests.proof.real.run import cells
from tests.proof.study import bilingual

GRAVITY = 9.80665
LATE = 0.008  # s


@pytest.fixture(scope="session")
def shaft() -> Recording:
    """A minute at 100 Hz: gyro and accelerometers late by LATE, noise of an MPU-6050.

    As in the real one the shaft points East, the unit's y along it.
    """
    rng = np.random.default_rng(5)
    t = np.round(np.arange(0.0, 60.0, 0.01), 9)

    def angle(at: np.ndarray) -> np.ndarray:
        return (
            1.5 - 1.5 * np.cos(2.0 * np.pi * at / 7.808) + 0.02 * np.sin(2.0 * np.pi * 2.0 * at)
            + 0.004 * np.sin(2.0 * np.pi * 4.3 * at) + 0.002 * np.sin(2.0 * np.pi * 12.8 * at)
        )  # fmt: skip

    observation = angle(t - LATE)
    rate = (angle(t - LATE + 5e-4) - angle(t - LATE - 5e-4)) / 1e-3
    columns = {
        "gyro_x": np.zeros_like(t), "gyro_y": rate, "gyro_z": np.zeros_like(t),
        "accel_x": GRAVITY * np.cos(observation), "accel_y": np.zeros_like(t),
        "accel_z": GRAVITY * np.sin(observation),
    }  # fmt: skip
    columns |= {
        name: value + rng.normal(0.0, 0.003 if name.startswith("gyro") else 0.03, len(t))
        for name, value in columns.items()
    }
    manifest = manifest_of(
        "shaft",
        {"gravity_m_s2": GRAVITY},
        {"shaft": (1, 0, 0)},
        mount={"quaternion_wxyz": [0.5, -0.5, -0.5, -0.5]},
    )
    table = Stream(t, {"shaft_angle": angle(t)})
    return Recording(manifest, Stream(t, columns), table=table)


# What is hidden does to the data what the physics would have done, and nothing else.


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


# Scores: what was hidden must be new, named, of its size, and alone.


def answer(*findings: tuple[str, str, float, float]) -> dict[str, Any]:
    return {
        "seconds": 1.0,
        "findings": [
            {"effect": e, "channels": [], "parameters": [{"name": n, "value": v, "u": u}]}
            for e, n, v, u in findings
        ],
    }


LOW_PASS = ("bandwidth", "time_constant", 0.007, 1e-4)
SHIFT = Hidden("shaft", "time_offset", Size(0.010, "s"))


def score(case: Hidden, after: dict[str, Any]) -> Score:
    return scored(case, after, answer(LOW_PASS), None)


@pytest.mark.parametrize(
    ("after", "outcome"),
    [
        (answer(LOW_PASS, ("time_offset", "seconds", 0.010, 1e-4)), "found, value right"),
        (answer(("time_offset", "seconds", 0.017, 2e-4)), "found, value right"),
        (answer(LOW_PASS, ("time_offset", "seconds", 0.014, 1e-4)), "found, value off"),
        (answer(("bandwidth", "time_constant", 0.017, 1e-4)), "missed"),
        (answer(LOW_PASS, ("unnamed", "frequency", 3.0, 0.1)), "missed"),
        (
            answer(("time_offset", "seconds", 0.017, 2e-4), ("clock_skew", "share", 1e-5, 1e-6)),
            "a wrong name",
        ),
        ({"seconds": 1.0, "failed": "ValueError: x"}, "explain failed"),
    ],
)
def test_shift_counts_by_the_change_of_all_delay(after: dict[str, Any], outcome: str) -> None:
    assert score(SHIFT, after).outcome == outcome


def test_nothing_new_is_right_where_nothing_is_hidden_or_seen() -> None:
    zero = Hidden("shaft", "time_offset", Size(0.0, "s"))
    unseen = Hidden("shaft", "axis_tilt", Size(0.01, "rad"), bilingual("absorbed", "被吸收"))
    named = answer(LOW_PASS, ("axis_tilt", "east", 0.01, 1e-3))
    for case in (zero, unseen):
        assert score(case, answer(LOW_PASS)).outcome == "rightly nothing new"
        assert score(case, named).outcome == "a wrong name"


def test_lost_samples_are_counted_together() -> None:
    case = Hidden("shaft", "dropped_samples", Size(5.0, "1", at=40.0))
    found = score(case, answer(("dropped_samples", "lost_1", 5.0, 0.1)))
    assert found.outcome == "found, value right"
    assert as_data(found)["stated"]["value"] == 5.0
    assert "5 at 40 s" in cells(found)


def test_every_transformation_is_hidden_in_three_sizes_and_zero() -> None:
    cases = hidden_cases(1)
    for name in TRANSFORMATIONS:
        sizes = [c.size.value for c in cases if c.name == name and c.recording.startswith("enc")]
        assert len(sizes) == 4
        assert sizes[0] == 0.0 < min(sizes[1:])
    assert all(why.en and why.zh for *_, why in NOT_HIDDEN)
    assert hidden_cases(1) == cases != hidden_cases(2)


# The hand analyses find what made-up data hold, and nothing in noise.


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


# The fit by hand to poses finds a made-up delay, lever arm and lean.

ARM = (0.03, -0.02, 0.05)


def test_delay_and_lever_arm_are_found() -> None:
    found = by_poses(recording(readings(arm=ARM), poses(delay=-0.005)))
    assert found["seconds"].value == pytest.approx(0.005, abs=2e-4)
    assert [found[f"r_{a}"].value for a in "xyz"] == pytest.approx(ARM, abs=1.5e-3)


def test_a_room_that_leans_is_found() -> None:
    found = by_poses(recording(readings(), tilted(poses(), np.radians(0.8))))
    lean = np.hypot(found["lean_x"].value, found["lean_y"].value)
    assert lean == pytest.approx(0.8, abs=0.1)
