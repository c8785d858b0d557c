"""The lever arm from the ramps, and the rate sensitivity without it."""

import json
from dataclasses import replace

import pytest

from schemas.calibration import Item
from schemas.recording import Recording
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.information.entry import type_b
from tasks.calibrate.information.lever_arm import lever_arm_information
from tasks.specifications.gather import gather
from tasks.specifications.jjf2003 import JJF2003

SEPARATED = "accel_rate_sensitivity_without_lever_arm"


def truth(shared, name: str) -> dict:
    return json.loads((shared / "plant" / name / "truth.json").read_text())


def p_of(shared, name: str) -> dict[str, float]:
    """Eq. (12) has the sign opposite to model (2)."""
    p = truth(shared, name)["parameters"]["P"]
    return {a + b: -p[i][j] for i, a in enumerate("xyz") for j, b in enumerate("xyz") if i != j}


def items_of(recording: Recording) -> dict[str, Item]:
    return calibrate(JJF2003, recording, run="r", code_version="v").items


def test_ramps_tell_the_lever_arm_from_the_rate_sensitivity(plant, shared) -> None:
    recording = plant("plant_lever_arm")
    found = lever_arm_information(gather(recording), items_of(recording))
    arm, separated = found["lever_arm"], found[SEPARATED]
    r = dict(zip("xyz", truth(shared, "plant_lever_arm")["effects"]["lever_arm"]["r"], strict=True))
    for axis in "xyz":
        assert abs(arm.value[axis] - r[axis]) < 2 * arm.u[axis]
        assert arm.u[axis] < 1e-4
    for element, true in p_of(shared, "plant_lever_arm").items():
        assert abs(separated.value[element] - true) < 2 * separated.u[element]
    assert separated.about == "accel_rate_sensitivity"
    equipment = type_b(items_of(recording)["accel_rate_sensitivity"], separated.value)
    assert all(u >= b > 0 for u, b in zip(separated.u.values(), equipment, strict=True))
    assert "type B contributions of the equipment" in arm.en


def test_without_a_budget_of_the_rate_sensitivity_there_is_no_uncertainty(plant) -> None:
    found = lever_arm_information(gather(plant("plant_lever_arm")), {})
    assert set(found["lever_arm"].U.values()) == {None}
    assert "No U stated" in found["lever_arm"].en


def test_without_a_lever_arm_there_is_none(plant, shared) -> None:
    recording = plant("plant_clean")
    found = lever_arm_information(gather(recording), items_of(recording))
    arm, separated = found["lever_arm"], found[SEPARATED]
    assert all(abs(arm.value[axis]) < 2 * arm.u[axis] for axis in "xyz")
    for element, true in p_of(shared, "plant_clean").items():
        assert abs(separated.value[element] - true) < 2 * separated.u[element]


def test_a_spike_in_a_ramp_is_left_out(plant) -> None:
    recording = plant("plant_lever_arm")
    evidence = gather(recording)
    ramp = next(s for s in recording.manifest.segments if s.name == "ramp027")
    rows = recording.imu.rows(ramp.t_start, ramp.t_end)
    accel = recording.imu.columns["accel_y"].copy()
    accel[rows.start + 40] = 1e4
    columns = {**recording.imu.columns, "accel_y": accel}
    spoiled = replace(recording, imu=replace(recording.imu, columns=columns))
    clean, found = (
        lever_arm_information(replace(evidence, recording=each), items_of(recording))
        for each in (recording, spoiled)
    )
    u = clean["lever_arm"].u["z"]
    assert found["lever_arm"].value["z"] == pytest.approx(clean["lever_arm"].value["z"], abs=u / 2)


@pytest.mark.parametrize("name", ["vn200_imu0_rate_table", "encoder_mpu6050_pitch_slow"])
def test_without_encoders_or_ramps_nothing_is_said(real, name: str) -> None:
    recording: Recording = real(name)
    assert lever_arm_information(gather(recording), {}) == {}


def test_an_unknown_gravity_says_nothing(plant) -> None:
    recording = plant("plant_lever_arm")
    station = recording.manifest.station.model_copy(update={"gravity_m_s2": None})
    manifest = recording.manifest.model_copy(update={"station": station})
    unknown = replace(recording, manifest=manifest)
    assert lever_arm_information(replace(gather(recording), recording=unknown), {}) == {}
