"""The joint method with gravity alone: rests by hand, and the moves between them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.calibration import Calibration
from schemas.recording import ACCEL, AXES, GYRO, Recording, Stream
from tasks.specifications.joint import JOINT
from tasks.specifications.joint.moves import Moves, fit_gravity, fit_moves
from tests.manifests import manifest_of
from tests.tasks.items_only import items_only

GRAVITY = 9.8
RATE = 100.0
K_ACCEL = np.array([[1.01, 0.004, -0.003], [0.0, 0.99, 0.006], [0.0, 0.0, 1.002]])
B_ACCEL = np.array([0.12, -0.2, 0.05])
K_GYRO = np.array([[0.99, 0.005, -0.01], [0.008, 1.02, 0.004], [-0.006, 0.01, 1.005]])
B_GYRO = np.array([0.01, -0.02, 0.005])


def by_joint(recording: Recording) -> Calibration:
    return items_only(JOINT, recording)


def held_by_hand(rests: int = 30, seed: int = 1, **station: float | None) -> Recording:
    """Rests of 3 s at random attitudes and smooth moves of 2 s between them, without labels."""
    rng = np.random.default_rng(seed)
    turns = [Rotation.random(random_state=rng).as_rotvec() for _ in range(rests)]
    rest, move = round(3 * RATE), round(2 * RATE)
    share = (np.arange(move) + 0.5) / move
    speed = 1.0 - np.cos(2 * np.pi * share)  # rad per turn, over the move, from rest to rest
    angle = share - np.sin(2 * np.pi * share) / (2 * np.pi)
    attitude = Rotation.identity()
    rates, ups = [], []
    for turn in turns:
        up = attitude.inv().apply([0, 0, 1])
        rates.append(np.zeros((rest, 3)))
        ups.append(np.tile(up, (rest, 1)))
        rates.append(speed[:, None] * turn / 2.0)
        ups.append((attitude * Rotation.from_rotvec(angle[:, None] * turn)).inv().apply([0, 0, 1]))
        attitude = attitude * Rotation.from_rotvec(turn)
    rate, force = np.concatenate(rates), GRAVITY * np.concatenate(ups)
    gyro = rate @ K_GYRO.T + B_GYRO + 1e-4 * rng.standard_normal(rate.shape)
    accel = force @ K_ACCEL.T + B_ACCEL + 1e-3 * rng.standard_normal(rate.shape)
    manifest = manifest_of("by_hand", {"gravity_m_s2": GRAVITY, **station}, standard="other")
    columns = dict(zip(GYRO + ACCEL, np.hstack([gyro, accel]).T.copy(), strict=True))
    times = np.round(np.arange(len(gyro)) / RATE, 9)
    return Recording(manifest, Stream(times, columns), digest="0" * 64)


def matrix(calibration: Calibration, triad: str) -> np.ndarray:
    """K (3, 3) of a triad; NaN where it is null."""
    found = np.full((3, 3), np.nan)
    for i, a in enumerate(AXES):
        for j, b in enumerate(AXES):
            name = f"{triad}_scale_factor" if i == j else f"{triad}_cross_coupling"
            value = calibration.items[name].value[a if i == j else a + b]
            found[i, j] = np.nan if value is None else value
    return found


@pytest.fixture(scope="module")
def by_hand() -> Calibration:
    return by_joint(held_by_hand())


def test_accelerometers_are_found_by_gravity_alone(by_hand):
    k = matrix(by_hand, "accel")
    known = np.triu_indices(3)
    assert k[known] == pytest.approx(K_ACCEL[known], abs=1e-4)
    assert list(by_hand.items["accel_bias"].value.values()) == pytest.approx(B_ACCEL, abs=1e-3)
    nulls = {e for e, v in by_hand.items["accel_cross_coupling"].value.items() if v is None}
    assert nulls == {"yx", "zx", "zy"}
    assert "by definition" in by_hand.unavailable["accel_cross_coupling"]
    assert by_hand.items["accel_scale_factor"].readings == ("joint.gravity_alone",)


def test_the_gyro_is_found_by_the_moves_between_rests(by_hand):
    assert matrix(by_hand, "gyro") == pytest.approx(K_GYRO, abs=1e-3)
    bias = np.degrees(B_GYRO)
    assert list(by_hand.items["gyro_bias"].value.values()) == pytest.approx(bias, abs=2e-3)
    assert "integrated gyro" in next(r.en for r in by_hand.remarks if r.code == "moves_residual")


def test_the_truth_lies_within_the_stated_uncertainties():
    z = []
    for seed in range(8):
        items = by_joint(held_by_hand(24, seed)).items
        for triad, true in (("gyro", K_GYRO), ("accel", K_ACCEL)):
            scale = items[f"{triad}_scale_factor"]
            for i, axis in enumerate(AXES):
                z.append((scale.value[axis] - true[i, i]) / scale.u[axis])
    assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.5


@pytest.mark.parametrize(
    ("recording", "reason"),
    [
        (lambda: held_by_hand(gravity_m_s2=None), "gravity is not stated"),
        (lambda: held_by_hand(rests=6), "rests with accelerometer readings; 12 or more"),
    ],
)
def test_what_is_not_enough_is_said(recording, reason):
    found = by_joint(recording())
    assert {v for item in found.items.values() for v in item.value.values()} == {None}
    assert all(reason in why for why in found.unavailable.values())


def test_rests_about_one_axis_only_determine_no_accelerometer():
    angle = np.linspace(0.0, 2 * np.pi, 40, endpoint=False)
    level = GRAVITY * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(40)])
    assert fit_gravity(level, GRAVITY, np.tile(1e-6 * np.eye(40), (3, 1, 1))) is None


def test_moves_about_the_vertical_tell_no_gyro():
    turns = np.zeros((20, 50, 3))
    turns[..., 2] = 0.03
    up = np.tile([0.0, 0.0, 1.0], (20, 1))
    assert fit_moves(Moves(turns, up, up)) is None


def test_xsens_session_gives_the_factory_scale_ratios(real):
    recording = real("xsens_multiposition")
    found = by_joint(recording)
    k, bias = matrix(found, "accel"), np.array(list(found.items["accel_bias"].value.values()))
    k[np.isnan(k)] = 0.0
    gravity = recording.manifest.station.gravity_m_s2
    means = np.array([
        recording.imu.stack(ACCEL, recording.imu.rows(s.t_start, s.t_end)).mean(axis=0)
        for s in found.segments
    ])  # fmt: skip
    misses = np.linalg.norm(np.linalg.solve(k, (means - bias).T), axis=0) - gravity
    assert len(misses) == 38
    assert np.sqrt(np.mean(misses**2)) < 0.0015
    counts = 415.0 * np.diag(k)
    published = np.array([414.45, 412.12, 414.51])
    assert counts / counts[0] == pytest.approx(published / published[0], rel=1e-3)
    assert counts == pytest.approx(published, rel=1e-3)
    factory = np.array([4778.0, 4758.0, 4766.0]) / 4778.0
    assert np.diag(matrix(found, "gyro")) == pytest.approx(factory, abs=3e-3)
