"""What a finding does to the certificate: its own elements move, the others do not."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from explained import explanation, finding, nothing_added

from schemas.discrepancy import FoundParameter
from schemas.laboratory import EquipmentLimit
from schemas.recording import Recording
from schemas.tolerance import Limit, Tolerance
from storage.formats.folder import read_folder
from tasks.explain.correction.adopt import corrected, uncertain_inputs
from tasks.explain.correction.consequences import consequences, moved_by
from tasks.explain.explain import explain
from tasks.explain.explanation import DeterminedModel, Finding
from tasks.model.model import Model
from tasks.model.term import nominal_values
from tasks.model.terms.environment import thermal_transient
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.standard import STANDARD_TERMS
from tasks.motion.whole import whole_motion
from tasks.specifications.jjf2003 import JJF2003
from tasks.words import say
from tests.shared import shared_path
from tests.tasks.items_only import items_only

STEP = 0.01  # deg/s
Build = Callable[..., Recording]


def biased(recording: Recording, channel: int, size: float) -> np.ndarray:
    """A constant in one channel, rad/s or m/s²."""
    added = nothing_added(recording)
    added[:, channel] = size
    return added


def added_to(recording: Recording, contribution: np.ndarray) -> Recording:
    return corrected(recording, (-contribution,))


def limits(item: str, unit: str, magnitude: float) -> Tolerance:
    limit = Limit(item=item, unit=unit, magnitude=magnitude)
    return Tolerance(manufacturer="test", model="ideal", document="d", limits=(limit,))


@pytest.fixture(scope="module")
def run(ideal_run) -> Recording:
    return ideal_run(dwell=6.0, noise=1e-6)


def test_before_is_what_was_read_and_after_is_less_what_was_found(run):
    added = biased(run, 0, float(np.radians(STEP)))
    spoilt = added_to(run, added)
    found = consequences(spoilt, explanation(spoilt, finding(added)))
    (moved,) = found.of_findings
    by_name = {(observed.item, observed.element): observed for observed in moved}
    assert set(by_name) == {("gyro_bias", "x"), ("gyro_fit_offset", "x")}
    bias = by_name["gyro_bias", "x"]
    certified = items_only(JJF2003, spoilt).items["gyro_bias"]
    assert bias.before == certified.value["x"] == pytest.approx(STEP, rel=1e-3)
    assert bias.after == pytest.approx(0.0, abs=1e-6)
    assert bias.unit == "deg/s"
    # What was taken off is known to a tenth of itself, far worse than the bias is read.
    assert pytest.approx(2.0 * 0.1 * STEP, rel=0.05) == bias.U
    assert bias.U_before == certified.U["x"] < 0.01 * bias.U
    assert bias.in_U == pytest.approx((bias.after - bias.before) / bias.U)


def test_what_a_widened_u_of_the_certificate_covers_is_no_error_of_it(run):
    """Positions that disagree widen the U that `calibrate` states; the change is given in it."""
    added = nothing_added(run)
    for k, segment in enumerate(run.manifest.segments or ()):
        added[run.imu.rows(segment.t_start, segment.t_end), 3] = 0.02 * (k == 2)
    spoilt = added_to(run, added)
    found = consequences(spoilt, explanation(spoilt, finding(added)))
    certified = items_only(JJF2003, spoilt).items["accel_bias"]
    (bias,) = (c for c in found.together if (c.item, c.element) == ("accel_bias", "x"))
    assert bias.U_before == certified.U["x"] > 2.0 * bias.U
    assert moved_by(bias) == pytest.approx(abs(bias.after - bias.before) / certified.U["x"])


def test_the_limits_of_the_laboratory_count_in_both_u(run):
    limit = EquipmentLimit(half_width=0.1, distribution="rectangular", source="test")
    added = nothing_added(run)
    added[:, 3] = 0.01 * run.imu.columns["accel_x"]
    spoilt = added_to(run, added)
    usual, wide = (
        {(c.item, c.element): c for c in consequences(spoilt, found, limits=own).together}
        for found in [explanation(spoilt, finding(added))]
        for own in (None, {"gravity": limit})
    )
    key = ("accel_scale_factor", "x")
    assert wide[key].U_before > 2.0 * usual[key].U_before
    assert wide[key].U > usual[key].U


def test_what_moves_less_than_a_twentieth_of_u_is_not_listed(run):
    U = items_only(JJF2003, run).items["accel_bias"].U["x"]
    assert U is not None
    for share, listed in ((0.04, 0), (0.06, 1)):
        added = biased(run, 3, share * U)
        found = consequences(run, explanation(run, finding(added)))
        assert len([c for c in found.of_findings[0] if c.item == "accel_bias"]) == listed


def test_each_finding_moves_its_own_and_all_together_move_both(run):
    first, second = biased(run, 1, 1e-4), biased(run, 4, 0.5)
    spoilt = added_to(added_to(run, first), second)
    found = consequences(spoilt, explanation(spoilt, finding(first), finding(second)))
    items = [{(c.item, c.element) for c in each} for each in found.of_findings]
    assert ("gyro_bias", "y") in items[0] - items[1]
    assert ("accel_bias", "y") in items[1] - items[0]
    assert {(c.item, c.element) for c in found.together} == items[0] | items[1]


def test_findings_that_make_up_for_each_other_are_told_of_together(run):
    """Two arms of which the recording tells the sum alone, each large and all but opposite."""
    arms = [replace(LEVER_ARM, variant=variant) for variant in (0, 1)]
    values = np.concatenate([nominal_values(STANDARD_TERMS), [0.5, 0, 0], [-0.49, 0, 0]])
    terms = (*STANDARD_TERMS, *arms)
    free = np.zeros(len(values), bool)
    free[[-6, -3]] = True
    model = Model.of(terms, values, free)
    for r, others in ((-0.99, 1), (-0.5, 0)):
        covariance = 1e-4 * np.array([[1.0, r], [r, 1.0]])
        determined = DeterminedModel(
            model, np.zeros(len(model.values), bool), covariance, whole_motion(run)
        )
        found = [
            finding(determined.contribution([arm.key]), "lever_arm", terms=(arm.key,))
            for arm in arms
        ]
        explained = replace(explanation(run, *found), determined=determined)
        declared = consequences(run, explained)
        assert len(declared.remarks) == others
        assert declared.sets == (((0, 1),) * 2 if others else ((0,), (1,)))
        assert (declared.of_findings[0] == declared.together) == bool(others)
        assert (declared.of_findings[0] == declared.of_findings[1]) == bool(others)


def test_a_verdict_that_changes_is_told(run):
    added = biased(run, 2, float(np.radians(STEP)))
    spoilt = added_to(run, added)
    tolerance = limits("gyro_bias", "deg/s", STEP / 2)
    found = consequences(spoilt, explanation(spoilt, finding(added)), tolerance)
    changes = {change.item: (change.before, change.after) for change in found.changes[0]}
    assert changes["gyro_bias"] == ("fail", "pass")
    assert changes["certificate"][0] == "fail"
    assert found.changes_together == found.changes[0]


def test_rows_where_a_contribution_is_not_known_stay_as_they_were_read(run):
    added = biased(run, 0, 1.0)
    added[5] = np.nan
    less = corrected(run, (added,)).imu.columns["gyro_x"]
    read = run.imu.columns["gyro_x"]
    assert less[5] == read[5]
    assert less[6] == pytest.approx(read[6] - 1.0)


def test_accumulated_angles_have_no_consequence_and_say_why(plant):
    ahrs = plant("ahrs_clean")
    found = consequences(ahrs, explanation(ahrs, finding(nothing_added(ahrs))))
    assert found.of_findings == ((),)
    assert "accumulated angles" in say(found.remarks[0], "en")


def test_limits_of_other_items_change_no_verdict(run):
    added = biased(run, 2, float(np.radians(STEP)))
    tolerance = limits("ahrs_scale_factor", "1", 0.1)
    assert consequences(run, explanation(run, finding(added)), tolerance).changes == ((),)


# U after a setting was put right is that of the whole reading, not of what was taken off.


@pytest.mark.parametrize("factor", [0.5, 1.14, 2.0, 57.2958])
def test_a_factor_is_as_uncertain_as_the_reading_that_it_multiplies(factor):
    right = np.linspace(-3.0, 3.0, 60).reshape(10, 6)
    found = FoundParameter(name="factor", value=factor, unit="1", u=0.01 * factor)
    setting = Finding(
        "range_setting", "", "", "", "", (0, 1, 2), (found,), (factor - 1.0) * right, 1.0, 1.0, 1.0
    )
    (one,) = uncertain_inputs([setting], None)
    assert np.allclose(np.abs(one.change(None)), np.abs(0.01 * right))


def test_the_scale_factor_after_a_range_put_right_has_the_factors_relative_uncertainty():
    recording = read_folder(shared_path("data/field/gyro_range_1137"))
    explanation = explain(recording, only=["bias_step"])  # a setting is seen before any search
    effects = consequences(recording, explanation)
    which = [each.effect for each in explanation.findings].index("range_setting")
    scale = {
        each.element: each
        for each in effects.of_findings[which]
        if each.item == "gyro_scale_factor"
    }
    assert set(scale) == {"x", "y", "z"}
    for one in scale.values():
        assert one.after is not None
        assert pytest.approx(0.02 * one.after, rel=0.02) == one.U


# How far the readings may be from those of a fitted time constant that is not well known.

AMPLITUDES = np.array([1e-3, 0.0, 0.0, 0.0, 0.0, 2e-3])  # rad/s, m/s²
TAU = 20.0  # s


@pytest.mark.parametrize("u_tau", [0.02, 8.0, 19.99, 30.0, 1e4])
def test_a_time_constant_no_better_known_than_its_size_moves_readings_by_its_slope(
    ideal_run, u_tau
):
    values = np.concatenate([nominal_values(STANDARD_TERMS), AMPLITUDES])
    free = np.arange(len(values)) >= len(values) - 6
    model = Model.of((*STANDARD_TERMS, thermal_transient(TAU)), values, free)
    motion = whole_motion(ideal_run())
    covariance = np.diag(np.append(np.zeros(6), u_tau**2))
    known = DeterminedModel(model, np.zeros(len(values), bool), covariance, motion)
    change = known.change(known.u * np.eye(7)[6])
    slope = AMPLITUDES * (np.exp(-motion.t / TAU) * motion.t / TAU**2)[:, None]
    bound = 0.4 * np.abs(slope).max(axis=0)  # a difference over half of τ is no derivative
    assert (np.abs(change / u_tau - slope) <= bound + 1e-15).all()
