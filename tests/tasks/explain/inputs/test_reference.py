"""A prediction from elsewhere in place of the standard's model."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from short_run import short_run

from schemas.recording import ACCEL, GYRO, Recording, Stream
from tasks.explain.evidence.findings import OTHER
from tasks.explain.explain import explain
from tasks.explain.explanation import CHANNELS
from tasks.explain.inputs.blocks import FullRate
from tasks.explain.inputs.prepared import MIN_DELAY, advanced, coarse_delay
from tasks.explain.inputs.reference import ReferencePrediction, in_unit_axes, with_seen_places
from tasks.model.model import predict
from tasks.model.term import nominal_values
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.pose import Tracking
from tasks.motion.whole import Motion, whole_motion
from tasks.words import say
from tests.manifests import manifest_of
from tests.moved_by_hand import by_hand, poses, readings, recording

# Poses of a body whose axes are not the unit's become poses of the unit.

SECONDS = 40.0
QUATERNION = ("qw", "qx", "qy", "qz")
TURN = Rotation.from_rotvec([0.1, -0.12, 0.15])  # 12.4°


def marked_askew(of: Recording, turn: Rotation = TURN) -> Recording:
    """The recording as if the markers had been stuck on turned."""
    pose = of.reference
    assert pose is not None
    attitude = Rotation.from_quat(pose.stack(QUATERNION), scalar_first=True) * turn
    columns = dict(zip(QUATERNION, attitude.as_quat(scalar_first=True).T, strict=True))
    return replace(of, reference=replace(pose, columns={**pose.columns, **columns}))


def moved(**more: tuple[float, ...]) -> Recording:
    return recording(readings(seconds=SECONDS, **more), poses(seconds=SECONDS))


def test_the_turn_of_the_markers_is_taken_back():
    askew = marked_askew(moved())
    pose, (remark,) = in_unit_axes(askew, whole_motion(askew))
    assert pose is not None
    found = Rotation.from_quat(pose.stack(QUATERNION), scalar_first=True)
    true = Rotation.from_quat(by_hand(pose.t).attitude, scalar_first=True)
    assert (true.inv() * found).mean().magnitude() < 2e-4
    assert "12.4°" in say(remark, "en")


def read_as(of: Recording, names: tuple[str, ...], matrix: object) -> Recording:
    """The recording with the columns of a triad exchanged or inverted."""
    exchanged = of.imu.stack(names) @ np.array(matrix, float).T
    columns = {**of.imu.columns, **dict(zip(names, exchanged.T, strict=True))}
    return replace(of, imu=replace(of.imu, columns=columns))


CYCLIC = ((0, 1, 0), (0, 0, 1), (1, 0, 0))
TWO_EXCHANGED = ((0, 1, 0), (1, 0, 0), (0, 0, 1))


@pytest.mark.parametrize(
    ("names", "matrix"),
    [
        (GYRO, CYCLIC), (ACCEL, CYCLIC), (GYRO, TWO_EXCHANGED), (ACCEL, np.diag([-1, -1, 1])),
        (ACCEL, np.diag([1, 1, -1])), (GYRO, np.diag([1, -1, -1])),
    ],
)  # fmt: skip
def test_columns_that_are_exchanged_in_one_triad_are_no_turn_of_the_body(names, matrix):
    askew = read_as(marked_askew(moved()), names, matrix)
    pose, (remark,) = in_unit_axes(askew, whole_motion(askew))
    assert pose is None
    assert "normal" not in say(remark, "en")
    assert "exchanged or inverted" in say(remark, "en")


@pytest.mark.parametrize(
    ("least", "most"),
    [
        ((0.6, 2.0, 2.0), (0.6, 2.0, 2.0)), ((0.3, 0.3, 0.3), (0.3, 0.3, 0.3)),
        ((0.5, 0.5, 2.0), (0.2, 2.0, 0.3)),
    ],
)  # fmt: skip
def test_clipped_rows_do_not_spoil_the_turn(least, most):
    """least, most: limits of each gyro to either side, times its largest rate."""
    askew = marked_askew(moved())
    gyro = askew.imu.stack(GYRO)
    low, high = (np.abs(gyro).max(axis=0) * limits for limits in (least, most))
    columns = {**askew.imu.columns, **dict(zip(GYRO, np.clip(gyro, -low, high).T, strict=True))}
    clipped = replace(askew, imu=replace(askew.imu, columns=columns))
    pose, _ = in_unit_axes(clipped, whole_motion(clipped))
    assert pose is not None
    found = Rotation.from_quat(pose.stack(QUATERNION), scalar_first=True)
    true = Rotation.from_quat(by_hand(pose.t).attitude, scalar_first=True)
    assert np.degrees((true.inv() * found).mean().magnitude()) < 0.1


def test_gyros_that_turn_about_one_axis_do_not_say_how_the_markers_sit():
    t = np.arange(0.0, SECONDS, 0.005)
    angle = np.sin(t)
    turned = Rotation.from_rotvec(np.outer(angle, [0.0, 0.0, 1.0])).as_quat(scalar_first=True)
    columns = {"gyro_x": 0.0 * t, "gyro_y": 0.0 * t, "gyro_z": np.cos(t)}
    flat = recording(Stream(t, columns), Stream(t, dict(zip(QUATERNION, turned.T, strict=True))))
    assert in_unit_axes(flat, whole_motion(flat)) == (None, ())


def test_a_lever_arm_is_named_and_told_along_the_units_axes():
    arm = (0.05, -0.03, 0.02)
    (finding,) = explain(marked_askew(moved(arm=arm))).findings
    assert finding.effect == "lever_arm"
    values = {one.name: one.value for one in finding.parameters}
    assert [values[f"r_{axis}"] for axis in "xyz"] == pytest.approx(arm, abs=2e-3)


# A long delay is told by the slow motion first: a fast one knows it only to within a period.

T = np.arange(0.0, 60.0, 0.01)
NOISE = 0.01  # rad/s


def rate(t: np.ndarray) -> np.ndarray:
    """Strokes of 8 s and a resonance of 13 Hz that is nearly as fast."""
    return np.asarray(np.sin(2.0 * np.pi * t / 8.0) + 0.5 * np.sin(2.0 * np.pi * 13.0 * t))


def shaft(late: float, moved: float = 1.0) -> FullRate:
    """A unit about whose y axis a shaft turns; its gyros have scale, cross coupling and bias."""
    nothing = np.zeros(len(T))
    speed = np.column_stack([nothing, moved * rate(T), nothing])
    level = np.tile([0.0, 0.0, 1.0], (len(T), 1))
    motion = Motion(T, level, np.full((len(T), 3), np.nan), speed, np.zeros_like(speed), 9.8)
    readings = np.zeros((len(T), 6))
    readings[:, :3] = moved * rate(T - late)[:, None] * [0.02, 0.97, -0.01] + 0.05
    readings[:, :3] += NOISE * np.random.default_rng(8).standard_normal((len(T), 3))
    one = np.ones((1, 2))
    return FullRate(readings, motion, np.full(len(T), -1), (), one, np.zeros(6), np.ones(6, bool))


@pytest.mark.parametrize("late", [0.012, 0.034, 0.1, -0.034, -0.2])
def test_a_delay_of_more_than_half_a_period_is_told(late):
    assert coarse_delay(shaft(late)) == pytest.approx(late, abs=0.002)


@pytest.mark.parametrize("late", [0.0, 0.6 * MIN_DELAY])
def test_a_short_delay_is_left_to_the_fit(late):
    assert coarse_delay(shaft(late)) == 0.0


def test_rests_and_a_short_run_tell_no_delay():
    assert coarse_delay(shaft(0.05, moved=0.0)) == 0.0
    whole = shaft(0.05)
    few = FullRate(
        whole.readings[:150], whole.motion.taken(np.arange(150)), whole.segment[:150], (),
        whole.segment_variance, whole.steps, whole.dithered,
    )  # fmt: skip
    assert coarse_delay(few) == 0.0


def test_what_is_not_known_is_not_compared():
    """The motion of a third of the run is not told, and the gyros read nonsense there."""
    whole = shaft(0.05)
    whole.motion.rate[2000:4000] = np.nan
    whole.readings[2000:4000] = 30.0
    assert coarse_delay(whole) == pytest.approx(0.05, abs=0.002)


def test_only_what_is_before_a_loss_is_looked_at():
    whole = shaft(0.05)
    whole.readings[3000:, :3] = shaft(-0.1).readings[3000:, :3]
    assert coarse_delay(whole, until=30.0) == pytest.approx(0.05, abs=0.002)


def test_stamps_are_taken_back():
    manifest = manifest_of("late", {"gravity_m_s2": 9.8})
    read = Recording(manifest, Stream(T, {name: np.zeros(len(T)) for name in CHANNELS}))
    assert advanced(read, 0.03).imu.t == pytest.approx(T - 0.03)


# Positions are smoothed no more than what the unit sees of the same motion asks for.

TREMOR, AT = 4e-4, 7.0  # m, Hz: far above the carrying, which ends at 1.3 Hz


def trembling(*, felt: bool, late: float = 0.0) -> Recording:
    """A hand that trembles as it carries the body; felt: by the unit as well."""
    reference, imu = poses(seconds=40.0), readings(seconds=40.0)
    seen = TREMOR * np.sin(2 * np.pi * AT * reference.t)
    reference = replace(
        reference, columns={**reference.columns, "px": reference.columns["px"] + seen}
    )
    pushed = -TREMOR * (2 * np.pi * AT) ** 2 * np.sin(2 * np.pi * AT * imu.t)
    attitude = Rotation.from_quat(by_hand(imu.t).attitude, scalar_first=True)
    inside = attitude.inv().apply(np.outer(pushed, (1.0, 0.0, 0.0))) * felt
    own = {name: imu.columns[name] + c for name, c in zip(ACCEL_SEEN_PLACES, inside.T, strict=True)}
    return recording(Stream(imu.t - late, {**imu.columns, **own}), reference)


ACCEL_SEEN_PLACES = ("accel_x", "accel_y", "accel_z")


def tracking_of(one: Recording) -> tuple[Tracking, Tracking]:
    motion = whole_motion(one)
    seen = with_seen_places(one, motion)
    assert motion.tracking is not None
    assert seen.tracking is not None
    return motion.tracking, seen.tracking


@pytest.mark.parametrize("late", [0.0, 0.045])
def test_what_the_accelerometers_feel_is_motion(late):
    alone, seen = tracking_of(trembling(felt=True, late=late))
    assert alone.place is not None
    assert seen.place is not None
    assert seen.place > AT


def test_what_they_do_not_feel_is_smoothed_as_before():
    alone, seen = tracking_of(trembling(felt=False))
    assert seen.place == alone.place


def test_a_stretch_that_outlasts_the_readings_is_compared_as_far_as_they_go():
    whole = trembling(felt=True)
    shorter = replace(whole, imu=whole.imu.at(whole.imu.rows(2.0, 38.0)))
    _, seen = tracking_of(shorter)
    assert seen.place is not None
    assert seen.place > AT


@pytest.fixture(scope="module")
def clean() -> Recording:
    return short_run(3, dwell_s=5.0).recording


@pytest.fixture(scope="module")
def right(clean) -> ReferencePrediction:
    """What the standard's model fitted to the recording says, whatever else is looked for."""
    nominal = explain(clean, only=["bias_step"]).nominal
    return ReferencePrediction(nominal, "the test's prediction")


def with_scale_factor(right: ReferencePrediction, recording: Recording, change: float):
    """The prediction with its first scale factor changed."""
    ideal = nominal_values(STANDARD_TERMS)
    moved = ideal.copy()
    moved[0] += change
    motion = whole_motion(recording)
    more = predict(STANDARD_TERMS, motion, moved) - predict(STANDARD_TERMS, motion, ideal)
    return ReferencePrediction(right.readings + more, right.model)


def test_a_right_prediction_leaves_nothing_to_say(clean, right):
    answer = explain(clean, reference=right)
    assert answer.verdict == "no_mismatch"
    assert answer.model == right.model
    np.testing.assert_array_equal(answer.nominal, right.readings)


@pytest.mark.rehearsal
def test_a_wrong_scale_factor_of_the_prediction_is_found_as_what_it_is(clean, right):
    answer = explain(clean, reference=with_scale_factor(right, clean, 1e-3))
    (finding,) = answer.findings
    assert (finding.effect, finding.follows) == ("unnamed", OTHER)
    (parameter,) = [p for p in finding.parameters if p.name == "gyro_matrix_xx"]
    assert parameter.value == pytest.approx(-1e-3, abs=3.0 * parameter.u)
    left = np.nanstd(answer.found - answer.nominal - finding.contribution)
    assert left < 0.02 * np.nanstd(finding.contribution)
