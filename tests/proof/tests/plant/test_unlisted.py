"""The laws that nobody listed: enough of each kind, as visible as asked, and what they remember."""

from collections import Counter

import numpy as np
import pytest

from tests.proof.plant.procedures import plan_of
from tests.proof.plant.simulate import drive, motions_of, visibility_beside
from tests.proof.plant.unlisted import BEHAVIOURS, LAWS, case_of, recordings, speed
from tests.proof.plant.world import Setting, World
from tests.proof.unlisted import Judged, judged


@pytest.fixture(scope="module")
def world() -> World:
    case = case_of(LAWS["last_fast_spin"], 5)
    setting = Setting(case, plan_of(case))
    return World(setting, motions_of(setting, (), *drive(case, setting.plan))[0])


def test_there_are_six_laws_of_each_kind_at_least() -> None:
    counts = Counter(law.behaviour for law in LAWS.values())
    assert set(counts) == set(BEHAVIOURS)
    assert min(counts.values()) >= 6


@pytest.mark.parametrize("name", LAWS)
def test_every_law_changes_its_own_triads_alone(world: World, name: str) -> None:
    reads = LAWS[name].sense(world)
    sizes = [np.ptp(reads[:3], axis=1).max() > 0.0, np.ptp(reads[3:], axis=1).max() > 0.0]
    assert np.isfinite(reads).all()
    assert sizes == [size > 0.0 for size in LAWS[name].triads]


def test_the_last_fast_spin_is_kept_through_slower_ones(world: World) -> None:
    reads = LAWS["last_fast_spin"].sense(world)[0]
    rate = world.motion.rates[0] / world.setting.top_rate
    slow = np.abs(rate) < 0.55
    assert np.abs(np.diff(reads))[slow[1:] & slow[:-1]].max() < 1e-12
    assert set(np.unique(np.round(reads / np.abs(reads).max(), 6))) == {-1.0, 0.0, 1.0}


def test_a_rectification_is_nothing_at_rest(world: World) -> None:
    still = speed(world) < 1e-6
    for law in LAWS.values():
        if law.behaviour == "rectification":
            assert np.abs(law.sense(world)[:, still]).max() < 1e-3


def test_a_recording_differs_from_the_clean_one_by_its_visibility() -> None:
    law = LAWS["tanh"]
    case = case_of(law, 5)
    clean, with_law = recordings(law, case, (0.0, 30.0))
    six = np.zeros((len(clean.imu.t), 6))
    for channel, name in enumerate(("gyro_x", "gyro_y", "gyro_z")):
        six[:, channel] = with_law.imu.columns[name] - clean.imu.columns[name]
    assert visibility_beside(case, six).z == pytest.approx(30.0, rel=0.1)  # rounded outputs


def test_a_name_of_another_kind_is_wrong_unless_it_lists_the_right_one() -> None:
    assert judged("hysteresis", [("hysteresis", ())]) == Judged("right", 1)
    assert judged("hysteresis", [("unnamed", ()), ("unnamed", ())]) == Judged("unnamed", 2)
    assert judged("hysteresis", [("hysteresis", ()), ("bias_step", ())]).outcome == "wrong"
    assert judged("hysteresis", [("bias_step", ("hysteresis",))]).outcome == "right"
    assert judged("hysteresis", []) == Judged("silent", 0)
    assert judged(None, [("bias_step", ())]).outcome == "wrong"
