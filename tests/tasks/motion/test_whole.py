"""The motion of a whole recording, against an independent rotation library."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from schemas.recording import Recording, Stream
from tasks.motion.reference_noise import reference_noise
from tasks.motion.samples import continuous
from tasks.motion.table import mean_rate
from tasks.motion.whole import agreeing_rate, is_rate_of, north_at_rest, whole_motion
from tests.manifests import manifest_of

T = np.arange(0.0, 8.0, 0.01)
DIRECTIONS = np.array([[0, 0, 1], [1, 0, 0], [0, 0.6, 0.8]], float)
angle = st.floats(-3.0, 3.0)


def recording(
    angles: np.ndarray | None = None,
    heading: float | None = 20.0,
    mount: Rotation | None = None,
    segments: list[dict] | None = None,
    reference: Stream | None = None,
) -> Recording:
    quaternion = (mount or Rotation.identity()).as_quat(scalar_first=True).tolist()
    axes = [{"name": f"a{k}", "direction": list(d)} for k, d in enumerate(DIRECTIONS)]
    manifest = manifest_of(
        "m",
        {"heading_deg": heading, "gravity_m_s2": 9.8, "table_axes": axes},
        mount={"quaternion_wxyz": quaternion},
        segments=segments,
    )
    table = None
    if angles is not None:
        table = Stream(T, {f"a{k}_angle": column for k, column in enumerate(angles.T)})
    return Recording(manifest, Stream(T, {}), table=table, reference=reference)


def attitude(angles: np.ndarray, heading: float, mount: Rotation) -> Rotation:
    whole = Rotation.from_euler("z", -heading, degrees=True)
    for direction, turned in zip(DIRECTIONS, angles.T, strict=True):
        whole = whole * Rotation.from_rotvec(turned[:, None] * direction)
    return whole * mount


@settings(deadline=None, max_examples=30)
@given(st.tuples(angle, angle, angle), st.floats(-180.0, 180.0), st.tuples(angle, angle, angle))
def test_the_vertical_and_north_are_those_of_the_attitude(angles, heading, turned):
    mount = Rotation.from_rotvec(turned)
    held = np.tile(angles, (len(T), 1))
    motion = whole_motion(recording(held, heading, mount))
    true = attitude(held[:1], heading, mount)
    assert motion.up[5] == pytest.approx(true.inv().apply([0, 0, 1])[0], abs=1e-9)
    assert motion.north[5] == pytest.approx(true.inv().apply([0, 1, 0])[0], abs=1e-9)
    rested = north_at_rest(recording(held, heading, mount), T[:1])
    assert rested[0] == pytest.approx(motion.north[0], abs=1e-12)
    assert np.abs(motion.rate).max() < 1e-9
    assert motion.force[5] == pytest.approx(9.8 * motion.up[5])


def test_rate_and_acceleration_follow_from_the_attitude_with_every_axis_moving():
    angles = np.column_stack([np.sin(T), 0.5 * T + 0.2 * np.cos(T), 0.3 * np.sin(2 * T)])
    mount = Rotation.from_rotvec([0.2, -0.4, 0.9])
    motion = whole_motion(recording(angles, 20.0, mount))
    step = 1e-4

    def rate(t: np.ndarray) -> np.ndarray:
        def at(s: np.ndarray) -> Rotation:
            moved = [np.sin(s), 0.5 * s + 0.2 * np.cos(s), 0.3 * np.sin(2 * s)]
            return attitude(np.column_stack(moved), 20.0, mount)

        return (at(t - step).inv() * at(t + step)).as_rotvec() / (2 * step)

    inner = slice(50, -50)
    assert motion.rate[inner] == pytest.approx(rate(T)[inner], abs=5e-3)
    change = (rate(T + step) - rate(T - step)) / (2 * step)
    assert motion.acceleration[inner] == pytest.approx(change[inner], abs=2e-2)


def test_a_heading_that_is_not_told_leaves_north_unknown():
    motion = whole_motion(recording(np.zeros((len(T), 3)), None))
    assert np.isnan(motion.north).all()
    assert motion.known.all()


def test_between_mountings_nothing_is_known():
    turned = Rotation.from_euler("x", 90, degrees=True).as_quat(scalar_first=True).tolist()
    segments = [
        {"name": "a", "kind": "static", "t_start": 1.0, "t_end": 2.0,
         "mount": {"quaternion_wxyz": [1, 0, 0, 0]}},
        {"name": "b", "kind": "static", "t_start": 4.0, "t_end": 5.0,
         "mount": {"quaternion_wxyz": turned}},
    ]  # fmt: skip
    motion = whole_motion(recording(np.zeros((len(T), 3)), segments=segments))
    assert motion.known.sum() == 200
    assert motion.up[150] == pytest.approx([0, 0, 1])
    assert motion.up[450] == pytest.approx([0, 1, 0], abs=1e-9)


def test_labels_tell_rests_rates_and_turns_and_nothing_beside_them():
    segments = [
        {"name": "r", "kind": "static", "up": "-y", "t_start": 0.0, "t_end": 1.0},
        {"name": "w", "kind": "rate", "axis": "z", "up": "+z", "rate_deg_s": -90.0,
         "t_start": 2.0, "t_end": 3.0},
        {"name": "t", "kind": "rotation", "axis": "x", "angle_deg": 360.0,
         "t_start": 4.0, "t_end": 6.0},
    ]  # fmt: skip
    motion = whole_motion(recording(segments=segments))
    assert motion.up[50] == pytest.approx([0, -1, 0])
    assert motion.rate[250] == pytest.approx([0, 0, -np.pi / 2])
    assert motion.rate[500] == pytest.approx([np.pi, 0, 0])
    assert np.isnan(motion.up[500]).all()
    assert np.isnan(motion.rate[150]).all()
    assert motion.known.sum() == 200


def test_a_reference_pose_gives_attitude_and_rate():
    times = np.arange(1.0, 7.0, 0.02)
    spin = np.array([0.1, -0.4, 0.7])
    turned = Rotation.from_rotvec(times[:, None] * spin)
    columns = dict(zip(("qw", "qx", "qy", "qz"), turned.as_quat(scalar_first=True).T, strict=True))
    motion = whole_motion(recording(reference=Stream(times, columns)))
    inside = (T > 1.2) & (T < 6.7)
    assert motion.rate[inside] == pytest.approx(np.tile(spin, (inside.sum(), 1)), abs=1e-6)
    true = Rotation.from_rotvec(T[:, None] * spin).inv().apply([0, 0, 1])
    assert motion.up[inside] == pytest.approx(true[inside], abs=1e-9)
    assert np.isnan(motion.rate[T < 1.0]).all()


# Angles that are asked for one by one: what is held is known, and what lies between is not.


def polled(recording: Recording, half_width_s: float, seed: int = 1) -> Recording:
    """The table read at times that are wrong by up to the half-width, unevenly and with gaps."""
    table, rng = recording.table, np.random.default_rng(seed)
    assert table is not None
    kept = np.sort(rng.choice(len(table), len(table) // 5, replace=False))
    asked = np.sort(table.t[kept] + rng.uniform(-half_width_s, half_width_s, len(kept)))
    columns = {name: values[kept] for name, values in table.columns.items()}
    stated = {"encoder": "polled", "half_width_s": half_width_s}
    manifest = recording.manifest.model_copy(update={"table_time": stated})
    return replace(recording, manifest=manifest, table=Stream(asked, columns))


def test_of_polled_angles_the_motion_is_that_of_rests_and_held_rates(plant):
    recording = polled(plant("plant_clean"), 0.02)
    motion = whole_motion(recording)
    held = np.zeros(len(motion.t), bool)
    for segment in recording.manifest.segments or ():
        rows = recording.imu.rows(segment.t_start, segment.t_end)
        if segment.kind == "static":
            assert not motion.rate[rows].any()
        elif segment.kind == "rate":
            size = np.degrees(np.linalg.norm(motion.rate[rows], axis=1))
            assert size == pytest.approx(abs(segment.rate_deg_s), rel=1e-12)
        if segment.kind in ("static", "rate"):
            held[rows] = True
    assert np.isfinite(motion.rate[held]).all()
    assert np.isnan(motion.rate[~held]).all()


def test_a_label_that_the_polled_angles_contradict_is_no_rate(plant):
    recording = polled(plant("plant_clean"), 0.02)
    segment = next(each for each in recording.manifest.segments or () if each.kind == "rate")
    assert agreeing_rate(recording, segment) is not None
    wrong = segment.model_copy(update={"rate_deg_s": 1.02 * segment.rate_deg_s})
    assert agreeing_rate(recording, wrong) is None


@pytest.mark.parametrize("step_s", [0.05, 0.9, 1.5])
def test_an_angle_that_runs_on_needs_no_unwrapping_over_a_gap(step_s):
    t = np.arange(0.0, 30.0, step_s)
    angle = np.radians(300.0 * t)
    assert continuous(Stream(t, {"a": angle}), ("a",))[:, 0] == pytest.approx(angle)


def test_an_encoder_that_starts_anew_each_turn_runs_on():
    t = np.arange(0.0, 30.0, 0.05)
    angle = np.radians(300.0 * t)
    noise = np.random.default_rng(3).normal(0.0, 1e-3, len(t))
    table = Stream(t, {"anew": angle % (2 * np.pi) + noise, "on": angle, "still": np.zeros(len(t))})
    found = continuous(table, ("anew", "on", "still"))
    assert np.diff(found[:, 0]) == pytest.approx(np.diff(angle + noise))
    assert np.array_equal(found[:, 1:], table.stack(("on", "still")))
    assert continuous(table, ("anew",), slice(0, 0)).shape == (0, 1)


def test_a_mean_rate_over_gaps_is_that_of_the_ends(plant):
    recording = plant("plant_clean")
    segment = max(
        (each for each in recording.manifest.segments or () if each.kind == "rate"),
        key=lambda each: abs(each.rate_deg_s or 0.0),
    )
    table = recording.table
    rows = np.flatnonzero((table.t >= segment.t_start) & (table.t <= segment.t_end))
    few = np.concatenate([rows[:3], rows[-3:]])
    columns = {name: values[few] for name, values in table.columns.items()}
    gapped = replace(recording, table=Stream(table.t[few], columns))
    assert mean_rate(gapped, segment) == pytest.approx(mean_rate(recording, segment), abs=1e-4)


# A table's reported rate is taken only where it is the rate of its angle.

INTERVAL = 0.01  # s
RAMP = 40  # samples of a ramp
NOISE = 4e-9  # rad, of the encoder


def _course() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, angle and rate of a table that dwells at rates between smooth ramps."""
    fine = 20
    ramp = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, RAMP * fine))
    pieces, last = [], 0.0
    for rate in (0.5, -1.0, 3.0, -5.0, 0.0, 2.0):
        pieces += [last + (rate - last) * ramp, np.full(400 * fine, rate)]
        last = rate
    rates = np.concatenate(pieces)
    steps = 0.5 * (rates[1:] + rates[:-1]) * INTERVAL / fine
    angles = np.concatenate([[0.0], np.cumsum(steps)])
    return np.arange(len(rates[::fine])) * INTERVAL, angles[::fine], rates[::fine]


@pytest.fixture
def turning() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    t, angle, rate = _course()
    rng = np.random.default_rng(3)
    return t, angle + NOISE * rng.standard_normal(len(t)), rate + 1e-7 * rng.standard_normal(len(t))


def test_the_measured_rate_is_taken(turning):
    assert is_rate_of(*turning)


@pytest.mark.parametrize("off", [1.0001, 0.999])
def test_a_rate_of_another_scale_is_not_taken(turning, off):
    t, angle, rate = turning
    assert not is_rate_of(t, angle, rate * off)


def test_a_late_rate_is_not_taken(turning):
    t, angle, rate = turning
    assert not is_rate_of(t, angle, np.interp(t - 0.05 * INTERVAL, t, rate))


def test_differences_of_the_angle_are_not_taken_for_a_measured_rate(turning):
    t, angle, _ = turning
    assert not is_rate_of(t, angle, np.gradient(angle, t))
    assert not is_rate_of(t, angle, np.concatenate([[0.0], np.diff(angle) / INTERVAL]))


def test_a_filtered_rate_is_not_taken(turning):
    t, angle, rate = turning
    assert not is_rate_of(t, angle, np.convolve(rate, [0.25, 0.5, 0.25], "same"))


def test_a_rate_that_lacks_what_the_encoder_reads_once_a_turn_is_not_taken(turning):
    t, angle, rate = turning
    assert not is_rate_of(t, angle, rate * (1.0 + 2e-5 * np.cos(angle)))


def test_gaps_and_few_samples_are_left_to_the_angle(turning):
    t, angle, rate = turning
    assert not is_rate_of(t[:40], angle[:40], rate[:40])
    with_gap = np.where(np.arange(len(t)) == 500, np.nan, rate)
    assert not is_rate_of(t, angle, with_gap)
    assert not is_rate_of(np.where(t > 10.0, t + 1.0, t), angle, rate)


# Means over the intervals of a unit that puts out angles, against integrals by hand.

SPAN = 0.1
T_WHOLE_INTERVALS = np.arange(0.0, 30.0, 0.005)
AT = np.arange(1.05, 29.0, SPAN)
FAST = 2.0 * np.pi * 2.0


def swinging(noise: float = 0.0) -> Recording:
    """About a level axis at 2 Hz, read ten times a second."""
    manifest = manifest_of(
        "swing", {"heading_deg": 0.0, "gravity_m_s2": 9.8}, {"a": (1.0, 0.0, 0.0)}
    )
    scatter = noise * np.random.default_rng(2).standard_normal(len(T_WHOLE_INTERVALS))
    table = Stream(
        T_WHOLE_INTERVALS, {"a_angle": angle_whole_intervals(T_WHOLE_INTERVALS) + scatter}
    )
    return Recording(manifest, Stream(AT, {}, SPAN), table=table)


def angle_whole_intervals(t: np.ndarray) -> np.ndarray:
    return np.asarray(0.3 * np.sin(FAST * t))


def test_a_rate_is_what_the_encoder_gained_between_the_readings():
    gained = (angle_whole_intervals(AT + SPAN / 2) - angle_whole_intervals(AT - SPAN / 2)) / SPAN
    motion = whole_motion(swinging())
    assert motion.rate[:, 0] == pytest.approx(gained, abs=1e-4)
    assert np.abs(0.3 * FAST * np.cos(FAST * AT) - gained).max() > 0.1


def test_the_vertical_is_the_mean_of_both_ends():
    ends = (
        np.cos(angle_whole_intervals(AT - SPAN / 2)),
        np.cos(angle_whole_intervals(AT + SPAN / 2)),
    )
    assert whole_motion(swinging()).up[:, 2] == pytest.approx(sum(ends) / 2.0, abs=1e-4)


def test_the_noise_of_two_angles_is_that_of_the_rate_between_them():
    noisy, exact = swinging(1e-4), whole_motion(swinging())
    motion = whole_motion(noisy)
    error = (motion.rate - exact.rate)[:, 0]
    stated = np.sqrt(reference_noise(noisy, motion).variance(motion, SPAN)[:, 0])
    assert error.std() == pytest.approx(np.sqrt((stated**2).mean()), rel=0.4)
