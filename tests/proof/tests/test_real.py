"""Values by hand of made-up recordings, and claims judged by what is known."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from schemas.recording import Recording, Stream
from tests.manifests import manifest_of
from tests.moved_by_hand import poses, readings, recording, tilted
from tests.proof.real.facts import Claim
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
)
from tests.proof.real.stated import DELAYS, EVERYTHING, KNOWN, Known, judged

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


# The hand analyses find what made-up data hold, and nothing in noise.


@pytest.mark.parametrize(
    "way", [delay_by_angle, delay_by_phase, delay_by_gravity, delay_by_pattern]
)
def test_four_ways_find_one_delay(way: Callable[[Recording], Measured], shaft: Recording) -> None:
    found = way(shaft)
    assert found.value == pytest.approx(LATE, abs=max(2.5 * found.u, 2e-4))
    assert found.u < 1e-3


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


@pytest.mark.rehearsal
def test_delay_lever_arm_and_a_room_that_leans_are_found() -> None:
    leaning = tilted(poses(delay=-0.005), np.radians(0.8))
    found = by_poses(recording(readings(arm=ARM), leaning))
    assert found["seconds"].value == pytest.approx(0.005, abs=2e-4)
    assert [found[f"r_{a}"].value for a in "xyz"] == pytest.approx(ARM, abs=1.5e-3)
    lean = np.hypot(found["lean_x"].value, found["lean_y"].value)
    assert lean == pytest.approx(0.8, abs=0.1)


# A claim is right or wrong by what is known by hand, and otherwise not known.

FACTS = (
    Known("rig", DELAYS, True, "late", "by hand", {"seconds": (0.010, 0.012)}),
    Known("rig", ("axis_wobble",), False, "does not lean", "by hand"),
    Known("rig", ("table_scale",), None, "scale not measured", "by hand"),
    Known("control", EVERYTHING, False, "nothing is left out", "by hand"),
)


def found(effect: str, parameters: tuple[tuple[str, float, float], ...] = (), **more: Any) -> dict:
    listed = [{"name": n, "value": v, "unit": "s", "u": u} for n, v, u in parameters]
    return {"effect": effect, "channels": ["gyro_x"], "parameters": listed, "share": 0.5, **more}


def judgements(recording: str, *findings: dict) -> list[str]:
    declared = judged(recording, {"findings": list(findings)}, FACTS, ())
    return [one.judgement for one in declared]


def test_a_delay_within_what_was_measured_is_right_and_one_beside_it_is_wrong() -> None:
    assert judgements("rig", found("time_offset", (("seconds", 0.011, 1e-5),))) == ["right"]
    assert judgements("rig", found("time_offset", (("seconds", 0.020, 1e-5),))) == ["wrong"]
    assert judgements("rig", found("time_offset", (("seconds", 0.020, 5e-3),))) == ["right"]
    (off,) = judged(
        "rig", {"findings": [found("time_offset", (("seconds", 0.02, 1e-5),))]}, FACTS, ()
    )
    assert off.evidence == "the name is right, its size is not: late (by hand)"


def test_delay_and_low_pass_count_together() -> None:
    both = (found("time_offset", (("seconds", 0.006, 1e-5),)), found("bandwidth"))
    assert judgements("rig", *both) == ["wrong", "wrong"]
    more = found("bandwidth", (("seconds", 0.005, 1e-5),))
    assert judgements("rig", both[0], more) == ["right", "right"]


def test_what_is_known_not_to_be_there_is_wrong() -> None:
    assert judgements("rig", found("axis_wobble")) == ["wrong"]
    assert judgements("control", found("lever_arm")) == ["wrong"]


def test_what_the_hand_does_not_decide_is_not_known() -> None:
    assert judgements("rig", found("table_scale"), found("hysteresis")) == ["not known"] * 2


def test_a_group_counts_by_any_of_its_names() -> None:
    grouped = found("gyro_angular_acceleration", group=("gyro_angular_acceleration", "bandwidth"))
    assert judgements("rig", grouped) == ["right"]


def test_a_finding_without_a_name_is_judged_only_where_it_was_tried() -> None:
    line = found("unnamed", follows={"en": "a line", "zh": "谱线"})
    tried = Claim(
        "rig", "a line", "false", "seen by the encoder",
        lambda answer: "line" in answer["findings"][0]["follows"],
    )  # fmt: skip
    assert judged("rig", {"findings": [line]}, FACTS, ()) == []
    (one,) = judged("rig", {"findings": [line]}, FACTS, (tried,))
    assert (one.judgement, one.evidence) == ("wrong", "seen by the encoder")


def test_every_known_range_has_a_source_and_rises() -> None:
    for fact in KNOWN:
        assert fact.source
        assert all(low < high for low, high in fact.within.values())
