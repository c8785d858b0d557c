"""The lever arm from the ramps, and the rate sensitivity without it."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import pytest

from schemas.calibration import Item
from schemas.recording import Recording
from tasks.calibrate.calibrate import evaluation_for, without_information
from tasks.calibrate.information.entry import type_b
from tasks.calibrate.information.lever_arm import lever_arm_information
from tasks.specifications.evidence import ClauseEvidence, gather
from tasks.specifications.jjf2003 import JJF2003
from tests.manifests import at_station

SEPARATED = "accel_rate_sensitivity_without_lever_arm"


def truth(shared, name: str) -> dict:
    return json.loads((shared / "plant" / name / "truth.json").read_text())


def p_of(shared, name: str) -> dict[str, float]:
    """Eq. (12) has the sign opposite to model (2)."""
    p = truth(shared, name)["parameters"]["P"]
    return {a + b: -p[i][j] for i, a in enumerate("xyz") for j, b in enumerate("xyz") if i != j}


Known = tuple[Recording, ClauseEvidence, dict[str, Item]]


@pytest.fixture(scope="module")
def known(plant) -> Callable[[str], Known]:
    """A simulated recording, what was gathered of it, and its items."""

    @cache
    def build(name: str) -> Known:
        recording = plant(name, 4)
        evidence = gather(recording)
        items = without_information(JJF2003, evidence, evaluation_for(recording)).items
        return recording, evidence, items

    return build


def test_ramps_tell_the_lever_arm_from_the_rate_sensitivity(known, shared):
    _, evidence, items = known("plant_lever_arm")
    found = lever_arm_information(evidence, items)
    arm, separated = found["lever_arm"], found[SEPARATED]
    r = dict(zip("xyz", truth(shared, "plant_lever_arm")["effects"]["lever_arm"]["r"], strict=True))
    for axis in "xyz":
        assert abs(arm.value[axis] - r[axis]) < 2 * arm.u[axis]
        assert arm.u[axis] < 1e-4
    for element, true in p_of(shared, "plant_lever_arm").items():
        assert abs(separated.value[element] - true) < 2 * separated.u[element]
    assert separated.about == "accel_rate_sensitivity"
    equipment = type_b(items["accel_rate_sensitivity"], separated.value)
    assert all(u >= b > 0 for u, b in zip(separated.u.values(), equipment, strict=True))
    assert "type B contributions of the equipment" in arm.en


def test_without_a_budget_of_the_rate_sensitivity_there_is_no_uncertainty(known):
    found = lever_arm_information(known("plant_lever_arm")[1], {})
    assert set(found["lever_arm"].U.values()) == {None}
    assert "No U stated" in found["lever_arm"].en
    assert SEPARATED not in found  # the specification has no such item


def test_without_a_lever_arm_there_is_none(known, shared):
    _, evidence, items = known("plant_clean")
    found = lever_arm_information(evidence, items)
    arm, separated = found["lever_arm"], found[SEPARATED]
    assert all(abs(arm.value[axis]) < 2 * arm.u[axis] for axis in "xyz")
    for element, true in p_of(shared, "plant_clean").items():
        assert abs(separated.value[element] - true) < 2 * separated.u[element]


def test_a_spike_in_a_ramp_is_left_out(known):
    recording, evidence, items = known("plant_lever_arm")
    ramp = next(s for s in recording.manifest.segments if s.name == "ramp027")
    rows = recording.imu.rows(ramp.t_start, ramp.t_end)
    accel = recording.imu.columns["accel_y"].copy()
    accel[rows.start + 40] = 1e4
    columns = {**recording.imu.columns, "accel_y": accel}
    spoiled = replace(recording, imu=replace(recording.imu, columns=columns))
    clean, found = (
        lever_arm_information(replace(evidence, recording=each), items)
        for each in (recording, spoiled)
    )
    u = clean["lever_arm"].u["z"]
    assert found["lever_arm"].value["z"] == pytest.approx(clean["lever_arm"].value["z"], abs=u / 2)


@pytest.mark.parametrize("name", ["vn200_imu0_rate_table", "encoder_mpu6050_pitch_slow"])
def test_without_encoders_or_ramps_nothing_is_said(real, name):
    recording: Recording = real(name)
    assert lever_arm_information(gather(recording), {}) == {}


def test_an_unknown_gravity_says_nothing(known):
    recording, evidence, _ = known("plant_lever_arm")
    unknown = at_station(recording, gravity_m_s2=None)
    assert lever_arm_information(replace(evidence, recording=unknown), {}) == {}
