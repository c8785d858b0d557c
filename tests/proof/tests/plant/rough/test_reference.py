"""Encoders and tracked poses that are no better than they are."""

import numpy as np
import pytest

from schemas.recording import Stream
from tests.proof.plant.case import inverse, product, vector_of
from tests.proof.plant.rough.runs import Tracking, scattered
from tests.proof.tests.plant.rough.short_runs import played, rough_of

DEGREE = np.pi / 180.0


def tracking(**fields: object) -> dict[str, object]:
    declared = {"rate_hz": 120, "position_noise": 0.0, "attitude_noise": 0.0} | fields
    return {"tracking": Tracking.model_validate(declared)}


def test_encoder_has_its_own_rate_steps_and_speeds() -> None:
    coarse = {"encoder": {"rate_hz": 40, "step": 0.3 * DEGREE, "noise": 0.0, "speeds": True}}
    table = played(rough_of("shaft", fields=coarse)).recording.table
    assert table is not None
    assert np.median(np.diff(table.t)) == pytest.approx(1 / 40)
    angle = table.columns["shaft_angle"]
    assert np.allclose(angle / (0.3 * DEGREE), np.rint(angle / (0.3 * DEGREE)))
    assert np.allclose(table.columns["shaft_rate"][1:-1], (angle[2:] - angle[:-2]) * 20)


def test_coarser_steps_mislead_more() -> None:
    misled = [
        played(
            rough_of("shaft", fields={"encoder": {"rate_hz": 100, "step": step, "noise": 0.0}})
        ).misread.std(axis=0)
        for step in (0.01 * DEGREE, 0.3 * DEGREE)
    ]
    assert misled[1][0] > 10 * misled[0][0] > 0.0
    assert misled[1][4] == pytest.approx(9.8 * 0.3 * DEGREE / np.sqrt(12) / np.sqrt(2), rel=0.5)


def test_stamps_scatter_and_still_rise() -> None:
    t = np.arange(5000) * 0.01
    stamps = scattered(np.random.default_rng(1), t, 4e-3)
    assert np.diff(stamps).min() > 0.0
    assert (stamps - t).std() == pytest.approx(4e-3, rel=0.1)
    assert scattered(np.random.default_rng(1), t, 0.0) == pytest.approx(t)


def test_poses_are_turned_against_the_unit_and_the_room() -> None:
    straight = played(rough_of("hand", fields=tracking())).recording.reference
    turned = played(rough_of("hand", fields=tracking(turn=(0.0, 0.03, 0.0)))).recording.reference
    tilted = played(rough_of("hand", fields=tracking(tilt=(0.01, 0.0, 0.0)))).recording.reference
    assert straight is not None
    assert turned is not None
    assert tilted is not None

    def pose(stream: Stream) -> np.ndarray:
        return np.stack([stream.columns[name] for name in ("qw", "qx", "qy", "qz")])

    against = vector_of(product(inverse(pose(turned)), pose(straight)))
    assert np.allclose(against, [[0.0], [0.03], [0.0]], atol=1e-6)
    room = vector_of(product(pose(tilted), inverse(pose(straight))))
    assert np.allclose(room, [[0.01], [0.0], [0.0]], atol=1e-6)
    moved = tilted.columns["pz"] - straight.columns["pz"]
    assert np.allclose(moved, 0.01 * straight.columns["py"], atol=1e-4)


def test_poses_come_late_with_gaps_and_between_the_frames() -> None:
    on_time = played(rough_of("hand", fields=tracking())).recording
    late = played(rough_of("hand", fields=tracking(delay=1 / 120))).recording
    assert on_time.reference is not None
    assert late.reference is not None
    assert late.reference.columns["px"][1:] == pytest.approx(
        on_time.reference.columns["px"][:-1], abs=1e-6
    )
    between = tracking(interpolated=True, gaps=((10.0, 10.5), (20.0, 21.0)))
    held = played(rough_of("hand", fields=between)).recording
    assert held.reference
    assert np.isin(held.reference.t, held.imu.t).all()
    assert np.diff(held.reference.t).max() == pytest.approx(1.0, abs=0.05)
    assert np.linalg.norm([held.reference.columns[q] for q in ("qw", "qx", "qy", "qz")],
                          axis=0) == pytest.approx(1.0)  # fmt: skip


def test_noise_of_poses_and_what_it_does_to_predicted_readings() -> None:
    rough = rough_of("hand", fields=tracking(position_noise=3e-4, attitude_noise=1e-3))
    run, clear = played(rough), played(rough_of("hand", fields=tracking()))
    assert run.recording.reference is not None
    assert clear.recording.reference is not None
    noise = run.recording.reference.columns["px"] - clear.recording.reference.columns["px"]
    assert noise.std() == pytest.approx(3e-4, rel=0.05)
    assert run.misread[:, 3:].std() > 0.1
    assert clear.misread[:, 3:].std() < 0.05 * run.misread[:, 3:].std()


def test_nuisances_of_the_reference_are_sealed_by_their_names() -> None:
    drawn = tracking(turn=(0.01, 0.0, 0.0), arm=(0.0, 0.02, 0.0), delay=4e-3)
    sealed = played(rough_of("hand", fields=drawn | {"stamp_jitter": 1e-3})).sealed
    assert set(sealed["nuisances"]) == {
        "time_offset", "reference_frame", "lever_arm", "timestamp_jitter"
    }  # fmt: skip
    assert sealed["nuisances"]["time_offset"] == {"seconds": -4e-3}
    assert played(rough_of("shaft")).sealed["nuisances"] == {}
