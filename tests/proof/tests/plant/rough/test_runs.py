"""Motions that are no procedure: a shaft to and fro, a body moved by hand."""

import numpy as np
import pytest

from tests.proof.plant.rough.runs import RoughCase, felt, move_by_hand
from tests.proof.tests.plant.rough.short_runs import played, rough_of


def test_hand_reaches_its_top_rate_and_rests_at_both_ends() -> None:
    run = played(rough_of("hand", fields={"top_rate": 3.5}))
    speed = np.abs(run.reported[:, :3])
    assert speed.max() == pytest.approx(3.5, rel=0.03)
    assert speed[:200].max() < 1e-3
    assert speed[-200:].max() < 1e-3


def test_motion_by_hand_has_no_fast_part() -> None:
    series = played(rough_of("hand")).reported[:, 0]
    power = np.abs(np.fft.rfft(series * np.hanning(len(series)))) ** 2
    frequency = np.fft.rfftfreq(len(series), 0.01)
    assert power[frequency > 12.0].sum() < 1e-4 * power.sum()


def test_specific_force_of_a_moving_body_is_the_second_derivative_of_its_place() -> None:
    rough = RoughCase.model_validate({"case": {"seed": 2}, "run": "hand", "duration_s": 20.0})
    t = np.arange(-1.0, 21.0, 0.002)
    hand = move_by_hand(rough, t)
    still = felt(hand, 9.8, np.zeros(3))
    inertial = still.into_unit(np.array([0.0, 0.0, 9.8]))
    moved = still.force - inertial
    # twice integrated, it leads from where the body rests first to where it rests last
    w, x, y, z = still.attitude
    up = moved[0] * 2 * (x * z - w * y) + moved[1] * 2 * (y * z + w * x)
    up += moved[2] * (w * w - x * x - y * y + z * z)
    risen = np.cumsum(np.cumsum(up)) * 0.002**2
    assert risen[-1] == pytest.approx(hand.place[2, -1] - hand.place[2, 0], abs=2e-3)
    assert np.ptp(hand.place[2]) > 0.05


def test_an_arm_adds_centripetal_and_tangential_force() -> None:
    arm = np.array([0.0, 0.03, 0.0])
    with_arm = rough_of("hand", fields={"tracking": {
        "rate_hz": 120, "position_noise": 0, "attitude_noise": 0, "arm": tuple(arm)
    }})  # fmt: skip
    run, centre = played(with_arm), played(rough_of("hand"))
    rate = run.reported[:, :3]
    change = np.gradient(rate, 0.01, axis=0)
    added = np.cross(change, arm) + np.cross(rate, np.cross(rate, arm))
    gain = np.linalg.inv(np.array(run.sealed["parameters"]["Ka"]))
    difference = (run.truth - centre.truth)[:, 3:] @ gain.T
    assert difference == pytest.approx(added, abs=0.02 * np.abs(added).max())


def test_shaft_turns_both_ways_rests_and_says_nothing_of_segments() -> None:
    run = played(rough_of("shaft"))
    rate = run.reported[:, 0]
    assert rate.max() > 1.0 > -1.0 > rate.min()
    assert (np.abs(rate) < 1e-6).mean() > 0.1
    assert run.recording.manifest.segments is None
    assert list(run.recording.streams()) == ["imu", "table"]
