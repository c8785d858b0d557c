"""A calibration with physics taken off: values, uncertainty, what it says of it."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from explained import finding

from schemas.calibration import Calibration
from schemas.discrepancy import FoundParameter
from schemas.recording import Recording
from schemas.text import Statement
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.information.entry import WITHOUT_EARTH
from tasks.explain.correction import adopt as sensitivity
from tasks.explain.correction.adopt import (
    CorrectionLines,
    adopt,
    corrected,
    correlation_of,
    uncertain_inputs,
    with_lines,
)
from tasks.explain.explanation import DeterminedModel, Finding
from tasks.model.model import Model, predict
from tasks.model.term import nominal_values
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.site import earth_rotation
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import whole_motion
from tasks.specifications.jjf2003 import JJF2003
from tests.manifests import at_station
from tests.tasks.items_only import items_only

TITLE = Statement(en="unit beside the axis", zh="安装偏心")
STANDARD_VALUES = nominal_values(STANDARD_TERMS)
FIFTH = slice(None, None, 5)  # rows that tell as much
ARM, U_ARM = (0.05, -0.03, 0.02), (1e-4, 2e-4, 3e-4)


def calibrated(recording: Recording) -> Calibration:
    return items_only(JJF2003, recording)


def added_by(term, recording: Recording, values: tuple[float, ...]) -> np.ndarray:
    motion, ideal = whole_motion(recording), STANDARD_VALUES
    whole = np.concatenate([ideal, values])
    return predict((*STANDARD_TERMS, term), motion, whole) - predict(STANDARD_TERMS, motion, ideal)


def lever_arm(recording: Recording) -> Finding:
    names = [parameter.name for parameter in LEVER_ARM.parameters]
    parameters = tuple(
        FoundParameter(name=name, value=value, unit="m", u=u)
        for name, value, u in zip(names, ARM, U_ARM, strict=True)
    )
    return finding(
        added_by(LEVER_ARM, recording, ARM), "lever_arm", parameters=parameters,
        title=TITLE, family="geometry", terms=(LEVER_ARM.key,),
    )  # fmt: skip


def determined(recording: Recording, r_xy: float = 0.0) -> DeterminedModel:
    """The arm of `lever_arm`, x and y of it correlated by r."""
    values = np.concatenate([STANDARD_VALUES, ARM])
    free = np.arange(len(values)) >= len(values) - 3
    model = Model.of((*STANDARD_TERMS, LEVER_ARM), values, free)
    correlation = np.eye(3)
    correlation[0, 1] = correlation[1, 0] = r_xy
    covariance = correlation * np.outer(U_ARM, U_ARM)
    return DeterminedModel(
        model, np.zeros(len(model.values), bool), covariance, whole_motion(recording)
    )


@pytest.fixture(scope="module")
def run(ideal_run) -> Recording:
    return ideal_run(dwell=6.0, noise=1e-6)


@pytest.fixture(scope="module")
def clean(run) -> Calibration:
    return calibrated(run)


@pytest.fixture(scope="module")
def displaced(run) -> tuple[Recording, Finding]:
    """A run of a unit off the axes, and the finding that says where it is."""
    found = lever_arm(run)
    return corrected(run, (-found.contribution,)), found


@pytest.fixture(scope="module")
def adopted(displaced) -> Calibration:
    recording, found = displaced
    return adopt(recording, [found], calibrated, determined(recording))


def test_items_are_those_of_a_unit_without_the_effect(clean, adopted):
    for name, item in clean.items.items():
        for element, value in item.value.items():
            assert adopted.items[name].value[element] == pytest.approx(value, abs=1e-9)


def test_uncertainty_grows_by_what_the_parameters_do_to_each_element(clean, adopted, displaced):
    """At a steady rate an arm r reads r_i·ω_j² along the axis i: u(p_ij) has u(r_i) in it."""
    found = displaced[1]
    before, after = (c.items["accel_rate_sensitivity"] for c in (clean, adopted))
    for element, u in after.u.items():
        along = "xyz".index(element[0])
        own, symbol = U_ARM[along], f"lever_arm.{found.parameters[along].name}"
        assert u == pytest.approx(math.hypot(before.u[element], own), rel=1e-3)
        budget = after.budgets[element]
        (line,) = [each for each in budget.inputs if each.symbol == symbol]
        assert abs(line.sensitivity) == pytest.approx(1.0, rel=1e-3)
        assert (line.u, line.unit) == (own, "m")
        assert sum(each.share for each in budget.inputs) == pytest.approx(1.0)
        assert budget.u_c == u
        assert after.U[element] == pytest.approx(after.k * u)
    same = adopted.items["gyro_scale_factor"]
    assert same.u == pytest.approx(clean.items["gyro_scale_factor"].u)


def test_result_says_what_was_taken_off_and_passes_no_unit(adopted):
    (term,) = adopted.terms
    assert (term.name, term.title_zh) == ("lever_arm", TITLE.zh)
    assert [(p.value, p.u) for p in term.parameters] == list(zip(ARM, U_ARM, strict=True))
    first = adopted.remarks[0]
    assert (first.code, first.blocks_pass) == ("terms_adopted", True)
    assert "lever_arm" in first.en
    assert "lever_arm" in first.zh
    assert "r_x = (50.00 ± 0.20) mm" in first.en
    assert not any(remark.code == "term_not_shown" for remark in adopted.remarks)
    assert Calibration.model_validate_json(adopted.model_dump_json()) == adopted


def test_a_term_that_the_recording_does_not_show_is_taken_with_a_warning(displaced):
    recording, found = displaced
    weak = replace(found, delta_bic=-3.0)
    adopted = adopt(recording, [weak], calibrated, determined(recording))
    (statement,) = [remark for remark in adopted.remarks if remark.code == "term_not_shown"]
    assert "-3.0" in statement.en


def test_earth_rotation_is_not_taken_off_twice(ideal_run):
    """At the pole only the diagonal is concerned; by eq. (7) it holds the Earth's rate."""
    recording = at_station(ideal_run(dwell=6.0), latitude_deg=90.0)
    term = earth_rotation(math.pi / 2)
    found = finding(added_by(term, recording, ()), "earth_rotation", parameters=())
    on_earth = corrected(recording, (-found.contribution,))
    by_clause = calibrated(on_earth).items["gyro_g_sensitivity"]
    assert by_clause.value["xx"] == pytest.approx(math.degrees(7.292115e-5), rel=1e-4)
    adopted = adopt(on_earth, [found], calibrated, None)
    item = adopted.items["gyro_g_sensitivity"]
    assert item.value["xx"] == pytest.approx(0.0, abs=1e-9)
    assert item.value_without_earth_rotation == item.value
    assert not any(remark.code.startswith("earth_rotation") for remark in adopted.remarks)


@pytest.mark.rehearsal
def test_the_site_is_judged_by_readings_that_have_earths_rotation(plant):
    """Less Earth's rotation they show none of it, which says nothing of latitude and heading."""
    full = plant("plant_earth_rotation")
    recording = replace(full, imu=full.imu.at(FIFTH), table=full.table.at(FIFTH))
    latitude = math.radians(recording.manifest.station.latitude_deg or 0.0)
    term = earth_rotation(latitude)
    found = finding(added_by(term, recording, ()), "earth_rotation", parameters=())
    whole = partial(calibrate, JJF2003, run="r", code_version="v")
    adopted, plain = adopt(recording, [found], whole, None), whole(recording)
    codes = {remark.code for remark in adopted.remarks}
    assert "earth_not_shown" not in codes | {remark.code for remark in plain.remarks}
    assert "earth_not_shown" in {
        remark.code for remark in calibrated(corrected(recording, (found.contribution,))).remarks
    }
    assert WITHOUT_EARTH in plain.information
    assert WITHOUT_EARTH not in adopted.information
    assert "information_as_recorded" in codes


def test_correlation_of_what_was_taken_off_is_in_u(run, clean):
    """What two parameters that make up for each other do to one element nearly cancels."""
    item, model = clean.items["gyro_bias"], determined(run, r_xy=-0.9)
    inputs = uncertain_inputs([lever_arm(run)], model)
    own = item.u["x"]
    assert own is not None
    changes = [{"x": 3.0 * own}, {"x": 2.0 * own}, {"x": 0.0}]
    lines = CorrectionLines(inputs, correlation_of(inputs, model), changes)
    budget = with_lines(item, lines).budgets["x"]
    factor = math.sqrt(1.0 + 9.0 + 4.0 - 2.0 * 0.9 * 3.0 * 2.0)
    assert budget.u_c == pytest.approx(factor * own)
    (pair,) = budget.correlations
    assert (pair.first, pair.second) == ("lever_arm.r_x", "lever_arm.r_y")
    assert pair.r == pytest.approx(-0.9)
    assert sum(line.share for line in budget.inputs) == pytest.approx(1.0)


def test_what_is_held_at_nothing_is_taken_off_nothing_and_stays_in_u(run, clean):
    """Along its own axis a steady rate shows the arm by p_xy alone."""
    values = np.concatenate([STANDARD_VALUES, [0.0, *ARM[1:]]])
    full = determined(run)
    held = full.model.free & (values == 0.0)
    arm = replace(full, model=replace(full.model, values=values), held=held)
    loose = replace(lever_arm(run), contribution=arm.contribution([LEVER_ARM.key]))
    recording = corrected(run, (-loose.contribution,))
    adopted = adopt(recording, [loose], calibrated, arm)
    assert [p.name for p in adopted.terms[0].parameters] == ["r_y", "r_z"]
    (statement,) = [each for each in adopted.remarks if each.code == "parameters_not_taken_off"]
    assert "r_x" in statement.en
    before, after = (c.items["accel_rate_sensitivity"] for c in (clean, adopted))
    assert after.value["xy"] == pytest.approx(before.value["xy"], abs=1e-9)
    assert after.u["xy"] == pytest.approx(math.hypot(before.u["xy"], U_ARM[0]), rel=1e-3)


def test_physics_that_is_known_beforehand_has_no_spread(run):
    """Earth's rate that was found is a check of the one that was taken off."""
    term = earth_rotation(0.5)
    model = Model.of((*STANDARD_TERMS, term), free=np.zeros(len(STANDARD_VALUES), bool))
    known = DeterminedModel(
        model, np.zeros(len(model.values), bool), np.zeros((0, 0)), whole_motion(run)
    )
    observed = FoundParameter(name="vertical_rate", value=7.0, unit="deg/h", u=20.0)
    found = finding(
        added_by(term, run, ()), "earth_rotation", parameters=(observed,), terms=(term.key,)
    )
    assert uncertain_inputs([found], known) == []


def test_segments_whose_motion_is_not_known_are_named(displaced):
    recording, found = displaced
    holed = found.contribution.copy()
    segment = (recording.manifest.segments or ())[3]
    holed[recording.imu.rows(segment.t_start, segment.t_start + 1.0)] = np.nan
    partly = replace(found, contribution=holed)
    adopted = adopt(recording, [partly], calibrated, determined(recording))
    (statement,) = [remark for remark in adopted.remarks if remark.code == "term_not_known"]
    assert statement.segments == (segment.name,)


def test_a_random_course_stays_in_the_readings_and_the_result_says_so(run, clean):
    wander = finding(
        1e-4 * np.sin(np.linspace(0.0, 9.0, len(run.imu)))[:, None] * np.ones(6),
        "bias_random_walk", parameters=(),
    )  # fmt: skip
    result = adopt(run, [wander], calibrated, None)
    assert result.items == clean.items
    assert result.terms == ()
    assert result.remarks[0].code == "term_not_taken_off"
    assert "bias_random_walk" in result.remarks[0].en


def test_directions_of_many_parameters_make_the_uncertainty_of_the_parameters(run, monkeypatch):
    found, model = lever_arm(run), determined(run, r_xy=-0.9)
    recording = corrected(run, (-found.contribution,))
    by_parameter = adopt(recording, [found], calibrated, model).items
    monkeypatch.setattr(sensitivity, "MANY", 2)
    by_direction = adopt(recording, [found], calibrated, model).items
    for name, item in by_parameter.items():
        assert pytest.approx(item.U, rel=1e-3) == by_direction[name].U
