"""A tracked body moved by hand: what is the tracking's is not charged to the unit."""

from dataclasses import replace

import numpy as np
import pytest
from short_run import short_run

from schemas.discrepancy import FoundParameter
from schemas.recording import Recording
from storage.formats.folder import read_folder
from tasks.explain.explain import explain
from tasks.explain.explanation import Explanation
from tests.moved_by_hand import poses, readings, recording, tilted
from tests.shared import shared_path

pytestmark = pytest.mark.rehearsal


ACCEL = slice(3, 6)
LONGEST = 100.0  # s: of three minutes of broad motion the first tell as much


def rms(explanation: Explanation, predicted: np.ndarray, read_by: Recording) -> float:
    names = ("accel_x", "accel_y", "accel_z")
    left = read_by.imu.stack(names) - predicted[:, ACCEL]
    return float(np.sqrt(np.nanmean(left**2)))


def parameters(explanation: Explanation, effect: str) -> dict[str, FoundParameter]:
    found = [f for f in (*explanation.findings, *explanation.small) if f.effect == effect]
    return {one.name: one for f in found for one in f.parameters}


def test_a_clean_unit_on_a_body_moved_by_hand_has_no_effects():
    explanation = explain(recording(readings(seconds=40.0), poses(seconds=40.0)))
    assert [finding.effect for finding in explanation.findings] == []


def test_a_clean_unit_whose_poses_have_no_positions_has_no_effects():
    imu, reference = readings(moving=False, seconds=40.0), poses(places=False, seconds=40.0)
    explanation = explain(recording(imu, reference))
    assert [finding.effect for finding in explanation.findings] == []


def test_a_delay_of_the_poses_and_a_lever_arm_are_told_apart():
    arm = (0.03, -0.02, 0.05)
    explanation = explain(recording(readings(arm=arm), poses(delay=-0.005)))
    found = parameters(explanation, "time_offset")
    assert found["seconds"].value == pytest.approx(0.005, abs=3e-4)
    at = parameters(explanation, "lever_arm")
    assert [at[f"r_{a}"].value for a in "xyz"] == pytest.approx(arm, abs=3e-3)
    off = [(at[f"r_{a}"].value - r) / at[f"r_{a}"].u for a, r in zip("xyz", arm, strict=True)]
    assert np.abs(off).max() < 3.0


def test_a_room_that_is_not_level_is_no_fault_of_the_unit():
    leaning = tilted(poses(seconds=32.0), np.radians(0.8))
    explanation = explain(recording(readings(seconds=32.0), leaning))
    names = {finding.effect for finding in explanation.findings}
    assert names <= {"reference_frame"}


@pytest.mark.rehearsal
def test_a_body_moved_by_hand_is_explained_by_its_positions_and_half_a_frame_of_delay():
    whole = read_folder(shared_path("data/rough/broad_18"))
    broad = replace(whole, imu=whole.imu.at(whole.imu.rows(0.0, LONGEST)))
    explanation = explain(broad)
    assert rms(explanation, explanation.found, broad) < 0.42
    late = parameters(explanation, "time_offset")["seconds"].value
    assert late == pytest.approx(0.00415, abs=6e-4)


def test_half_a_minute_of_poses_that_tell_slow_motion_only_is_explained():
    reference = poses(turn_noise=0.01, place_noise=0.01, seconds=32.0)
    explanation = explain(recording(readings(seconds=32.0), reference))
    assert explanation.verdict == "no_mismatch"


# Physics of the catalogue, written with other equations than its terms, still gets its name.

SHORT = 5.0  # s
# What a knock changes is told from the supply's course where it is seen for longer.


def test_a_short_run_without_any_of_them_is_clean():
    answer = explain(short_run(3, SHORT).recording)
    assert (answer.verdict, answer.findings) == ("no_mismatch", ())
    assert answer.p_value > 0.01
    left = answer.recording.imu.stack(("gyro_x", "accel_x")) - answer.found[:, [0, 3]]
    noise = np.nanstd(left, axis=0) / answer.noise[[0, 3]]
    assert (np.abs(noise - 1.0) < 0.3).all()
