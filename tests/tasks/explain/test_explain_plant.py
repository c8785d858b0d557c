"""`explain` on the simulated recordings, end to end: names, values, the gap that is closed.

What each effect makes of the readings is worked out here anew, from the encoders and `truth.json`.
"""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.recording import ACCEL, Recording
from storage.formats.folder import read_folder
from tasks.explain.correction.consequences import consequences
from tasks.explain.explain import explain
from tasks.explain.explanation import Explanation
from tasks.words import say
from tests.shared import shared_path

EARTH = 7.292115e-5  # rad/s
WIDE = 4  # rows of the mean that effects are compared on
CLOSED = 0.95
COVERAGE = 2.0  # standard uncertainties
# Every so many rows: they tell as much, and sooner. Fewer are left out where moves tell it.
STEPS = {
    "plant_lever_arm": 2, "plant_time_offset": 2, "plant_earth_rotation": 4,
    "plant_tilt_and_temperature": 6, "plant_clean": 6, "plant_unlisted": 6,
}  # fmt: skip


@cache
def recording(name: str) -> Recording:
    whole, kept = read_folder(shared_path(f"data/plant/{name}")), slice(None, None, STEPS[name])
    assert whole.table is not None
    return replace(whole, imu=whole.imu.at(kept), table=whole.table.at(kept))


@cache
def explained(name: str) -> Explanation:
    return explain(recording(name))


def truth(name: str) -> dict:
    return json.loads(shared_path(f"data/plant/{name}/truth.json").read_text())["effects"]


def effects(name: str) -> list[str]:
    return [each.effect for each in explained(name).findings]


def attitudes(run: Recording, t: np.ndarray) -> Rotation:
    """R_n_body of the three axes, whose mount is the identity and whose heading is 0."""
    assert run.table is not None
    names = ("outer_angle", "middle_angle", "inner_angle")
    angles = np.column_stack([np.interp(t, run.table.t, run.table.columns[name]) for name in names])
    return Rotation.from_euler("ZXZ", angles)


def in_body(run: Recording, vector: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(n, 3) a vector of n as the body sees it."""
    return attitudes(run, t).inv().apply(np.tile(vector, (len(t), 1)))


def rates(run: Recording, t: np.ndarray, step: float = 0.02) -> np.ndarray:
    """(n, 3) rad/s from the turn between just before and just after."""
    turn = attitudes(run, t - step).inv() * attitudes(run, t + step)
    return turn.as_rotvec() / (2.0 * step)


def nominal(run: Recording, t: np.ndarray) -> np.ndarray:
    """(n, 6) what an ideal unit reads of the encoders and gravity."""
    gravity = run.manifest.station.gravity_m_s2
    assert gravity is not None
    return np.hstack([rates(run, t), in_body(run, np.array([0.0, 0.0, gravity]), t)])


def no_rate(force: np.ndarray) -> np.ndarray:
    return np.hstack([np.zeros_like(force), force])


def earth(run: Recording, _: dict) -> np.ndarray:
    latitude = np.radians(run.manifest.station.latitude_deg or np.nan)
    there = EARTH * np.array([0.0, np.cos(latitude), np.sin(latitude)])
    observed = in_body(run, there, run.imu.t)
    return np.hstack([observed, np.zeros_like(observed)])


def lever_arm(run: Recording, true: dict) -> np.ndarray:
    """Second differences of where the arm's end is."""
    t, step = run.imu.t, 0.05
    here, before, after = (
        attitudes(run, t + shift).apply(true["r"]) for shift in (0.0, -step, step)
    )
    moved = (before - 2.0 * here + after) / step**2
    return no_rate(attitudes(run, t).inv().apply(moved))


def time_offset(run: Recording, true: dict) -> np.ndarray:
    t = run.imu.t
    return nominal(run, t - true["seconds"]) - nominal(run, t)


def tilt_and_temperature(run: Recording, true: dict) -> np.ndarray:
    """A base turned by a small vector tilts gravity the other way; biases follow T − 25 °C."""
    tilt, gravity = true["axis_tilt"], run.manifest.station.gravity_m_s2
    assert gravity is not None
    turned = np.array([tilt["east"], tilt["north"], 0.0])
    leaning = in_body(run, -np.cross(turned, [0.0, 0.0, gravity]), run.imu.t)
    warmer = run.imu.columns["temperature"] - 25.0
    per_kelvin = np.concatenate([
        true["temperature_bias"]["gyro"], true["temperature_bias"]["accel"]
    ])  # fmt: skip
    return no_rate(leaning) + warmer[:, None] * per_kelvin


def relaxation(run: Recording, true: dict) -> np.ndarray:
    """Each move to another position is followed by a force that fades."""
    own = true["x_stress_relaxation"]
    t, since = run.imu.t, np.full(len(run.imu.t), np.inf)
    for segment in run.manifest.segments or ():
        if segment.name.startswith("move"):
            after = t >= segment.t_end
            since[after] = t[after] - segment.t_end
    return no_rate(np.exp(-since / own["tau"])[:, None] * own["accel"])


def averaged(series: np.ndarray) -> np.ndarray:
    rows = len(series) // WIDE * WIDE
    return series[:rows].reshape(-1, WIDE, series.shape[1]).mean(axis=1)


def unabsorbed(run: Recording, effect: np.ndarray) -> np.ndarray:
    """What a fit of models (1) and (2) leaves of an effect (n, 6), in units of the noise."""
    ideal = nominal(run, run.imu.t)
    rate, up, one = ideal[:, :3], ideal[:, 3:], np.ones((len(ideal), 1))
    left = []
    for channel in range(6):
        others = [j for j in range(3) if j != channel - 3]
        columns = [up, one, rate] if channel < 3 else [up, one, rate[:, others] ** 2]
        base, series = averaged(np.hstack(columns)), averaged(effect[:, channel : channel + 1])
        size = np.linalg.norm(base, axis=0)
        values, *_ = np.linalg.lstsq(base / size, series, rcond=None)
        left.append(series - base / size @ values)
    return np.hstack(left)


def closed(name: str, effect: Callable[[Recording, dict], np.ndarray]) -> float:
    """1 − |true − found|²/|true|² of what the standard's model does not absorb."""
    run, answer = recording(name), explained(name)
    found = sum((each.contribution for each in answer.findings), np.zeros((len(run.imu.t), 6)))
    true = unabsorbed(run, effect(run, truth(name))) / answer.noise
    missed = true - unabsorbed(run, found) / answer.noise
    return 1.0 - float((missed**2).sum() / (true**2).sum())


def assert_known(name: str, effect: str, true: dict[str, float]) -> None:
    finding = next(each for each in explained(name).findings if each.effect == effect)
    text = {parameter.name: parameter for parameter in finding.parameters}
    assert set(text) == set(true)
    for key, value in true.items():
        assert text[key].u > 0.0
        assert abs(text[key].value - value) < COVERAGE * text[key].u, key


@pytest.mark.rehearsal
def test_where_nothing_is_missing_nothing_is_said():
    answer = explained("plant_clean")
    assert answer.verdict == "no_mismatch"
    assert answer.findings == ()
    assert answer.p_value > 0.01
    run = recording("plant_clean")
    left = run.imu.stack(("gyro_x", "accel_x")) - answer.found[:, [0, 3]]
    middle = np.nanstd(left, axis=0) / answer.noise[[0, 3]]
    assert (np.abs(middle - 1.0) < 0.3).all()


@pytest.mark.parametrize(
    ("name", "named"),
    [
        pytest.param(  # by the command in `make test`
            "plant_earth_rotation", ["earth_rotation"], marks=pytest.mark.rehearsal
        ),
        pytest.param("plant_lever_arm", ["lever_arm"], marks=pytest.mark.rehearsal),
        pytest.param("plant_time_offset", ["time_offset"], marks=pytest.mark.rehearsal),
        ("plant_tilt_and_temperature", ["axis_tilt", "temperature_bias"]),
    ],
)
def test_the_missing_physics_is_named_and_nothing_else(name, named):
    assert effects(name) == named
    assert explained(name).verdict == "explained"
    assert explained(name).p_value < 1e-6
    assert all(each.held_out_gain > 10.0 for each in explained(name).findings)


@pytest.mark.rehearsal
def test_earth_turns_as_fast_as_at_this_latitude():
    vertical = np.degrees(EARTH * np.sin(np.radians(39.9))) * 3600.0
    assert_known("plant_earth_rotation", "earth_rotation", {"vertical_rate": vertical})


@pytest.mark.rehearsal
def test_earth_rotation_is_what_the_clause_reads_as_g_sensitivity_of_a_vertical_axis():
    name = "plant_earth_rotation"
    (moved,) = consequences(recording(name), explained(name)).of_findings
    observed = {(each.item, each.element): each for each in moved}["gyro_g_sensitivity", "zz"]
    assert observed.before is not None
    assert observed.after is not None
    vertical = np.degrees(EARTH * np.sin(np.radians(39.9)))
    assert observed.before - observed.after == pytest.approx(vertical, rel=0.05)


@pytest.mark.rehearsal
def test_the_arm_is_as_long_as_it_was_made():
    true = dict(zip(("r_x", "r_y", "r_z"), truth("plant_lever_arm")["lever_arm"]["r"], strict=True))
    assert_known("plant_lever_arm", "lever_arm", true)


@pytest.mark.rehearsal
def test_the_delay_is_as_long_as_it_was_made():
    assert_known("plant_time_offset", "time_offset", truth("plant_time_offset")["time_offset"])


def test_tilt_and_temperature_coefficients_are_as_they_were_made():
    true, name = truth("plant_tilt_and_temperature"), "plant_tilt_and_temperature"
    assert_known(name, "axis_tilt", true["axis_tilt"])
    per_kelvin = true["temperature_bias"]["gyro"] + true["temperature_bias"]["accel"]
    channels = [f"{sensor}_{axis}" for sensor in ("gyro", "accel") for axis in "xyz"]
    assert_known(name, "temperature_bias", dict(zip(channels, per_kelvin, strict=True)))


@pytest.mark.rehearsal
def test_what_is_in_no_catalogue_is_unnamed_and_says_what_it_follows():
    answer = explained("plant_unlisted")
    assert answer.verdict == "unexplained"
    first = answer.findings[0]
    assert first.effect == "unnamed"
    assert first.channels == (3, 4, 5)
    assert first.follows is not None
    assert "relaxation after each change of position" in say(first.follows, "en")
    assert "弛豫" in say(first.follows, "zh")
    true = truth("plant_unlisted")["x_stress_relaxation"]["accel"]
    assert_known("plant_unlisted", "unnamed", dict(zip(ACCEL, true, strict=True)))


@pytest.mark.parametrize(
    ("name", "effect"),
    [
        pytest.param("plant_earth_rotation", earth, marks=pytest.mark.rehearsal),
        pytest.param(
            "plant_lever_arm",
            lambda run, true: lever_arm(run, true["lever_arm"]),
            marks=pytest.mark.rehearsal,
        ),
        pytest.param(
            "plant_time_offset",
            lambda run, true: time_offset(run, true["time_offset"]),
            marks=pytest.mark.rehearsal,
        ),
        ("plant_tilt_and_temperature", tilt_and_temperature),
        pytest.param("plant_unlisted", relaxation, marks=pytest.mark.rehearsal),
    ],
    ids=["earth_rotation", "lever_arm", "time_offset", "tilt_and_temperature", "unlisted"],
)
def test_the_gap_that_the_standard_model_leaves_is_closed(name, effect):
    assert closed(name, effect) >= CLOSED
