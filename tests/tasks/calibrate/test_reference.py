"""Errors that certificates state as functions: taken off the reference, or counted with U."""

import math
from collections.abc import Callable
from dataclasses import replace
from datetime import date, timedelta
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.laboratory import MeasurementStandard
from schemas.recording import GYRO, Recording, Stream
from tasks.calibrate.calibrate import evaluation_for
from tasks.calibrate.reference import as_certified
from tasks.specifications.estimate import Specification
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.joint import JOINT
from tasks.uncertainty.equipment import stated_limits
from tasks.validation import run2003
from tasks.validation.coverage import simulate
from tasks.validation.simulated_units import draw_simulated_unit
from tests.tasks.items_only import items_only

CALIBRATED, MEASURED_ON = date(2026, 3, 1), date(2026, 9, 1)
ROWS = [(10.0, 2e-4, 4e-5), (100.0, -1e-4, 2e-5), (300.0, 3e-4, 1e-5)]  # °/s, deviation, U
TABLE = [{"at": at, "deviation": deviation, "U": U} for at, deviation, U in ROWS]
AXES = "xyz"


def standard(name: str, function: dict[str, Any], **more: Any) -> MeasurementStandard:
    return MeasurementStandard.model_validate({
        "name": "Table", "name_zh": "转台", "serial": "T-1", "accuracy": "", "certificate": "C-9",
        "calibrated_on": CALIBRATED, "functions": {name: function}, **more,
    })  # fmt: skip


def calibrated(
    specification: Specification, recording: Recording, *standards: MeasurementStandard
) -> Calibration:
    limits = stated_limits(standards, MEASURED_ON)
    return items_only(
        specification, as_certified(recording, standards), evaluation_for(recording, own=limits)
    )


def deviates(rate: float) -> float:
    """By how much a table indicates too much: by hand from the rows, in the terms of a ruler."""
    (a, da, _), (b, db, _), (c, dc, _) = ROWS
    if rate < b:
        return da + (db - da) * (rate - a) / (b - a)
    return db + (dc - db) * (rate - b) / (c - b)


def on_wrong_table(
    recording: Recording, scale: np.ndarray, error: Callable[[float], float]
) -> Recording:
    """What the gyros of scale (3, 3) read where the table turned slower than it says."""
    columns = {name: column.copy() for name, column in recording.imu.columns.items()}
    for segment in recording.manifest.segments or ():
        if segment.kind != "rate" or segment.axis is None:
            continue
        indicated = math.radians(segment.rate_deg_s or 0.0)
        missing = indicated / (1.0 + error(abs(segment.rate_deg_s or 0.0))) - indicated
        rows = recording.imu.rows(segment.t_start, segment.t_end)
        for channel, name in enumerate(GYRO):
            columns[name][rows] += scale[channel, AXES.index(segment.axis)] * missing
    return replace(recording, imu=Stream(recording.imu.t, columns))


@pytest.fixture(scope="module")
def simulated() -> tuple[Recording, np.ndarray]:
    """A run on an exact table with encoders, every third row of it, and the true scale factors of
    its unit.
    """
    unit, kept = draw_simulated_unit(4, run2003.RATE_HZ, ideal=True), slice(None, None, 3)
    recording, _ = run2003.record(unit)
    assert recording.table is not None
    thinned = replace(recording, imu=recording.imu.at(kept), table=recording.table.at(kept))
    return thinned, np.array(unit.unit.gyro.scale)


@pytest.mark.parametrize("specification", [JJF2003, JOINT], ids=["clauses", "joint"])
@pytest.mark.parametrize("encoders", [True, False], ids=["encoders", "labels"])
def test_a_table_that_deviates_is_corrected_by_its_certificate(simulated, specification, encoders):
    exact, scale = simulated
    exact = exact if encoders else replace(exact, table=None)
    wrong = on_wrong_table(exact, scale, deviates)
    right = items_only(specification, exact).items["gyro_scale_factor"].value
    left = items_only(specification, wrong).items["gyro_scale_factor"].value
    paper = standard("rate", {"deviation": "corrected", "rows": TABLE})
    corrected = calibrated(specification, wrong, paper).items["gyro_scale_factor"].value
    # A line through points each off by d(ω)·ω is off by the mean of d, weighted with ω².
    rates = np.array([10.0, 50.0, 100.0, 200.0, 300.0])
    off = rates**2 @ [deviates(rate) / (1.0 + deviates(rate)) for rate in rates] / (rates @ rates)
    assert abs(off) > 1e-4
    for axis in AXES:
        assert corrected[axis] == pytest.approx(right[axis], abs=2e-8)
        assert left[axis] - right[axis] == pytest.approx(-off * right[axis], rel=0.02)


def test_a_unit_that_accumulates_angles_is_corrected_too():
    recording = simulate("jjf1536", 3)[0]
    rates = {abs(s.rate_deg_s) for s in recording.manifest.segments or () if s.rate_deg_s}
    rows = [{"at": at, "deviation": 3e-4, "U": 1e-5} for at in (min(rates), max(rates))]
    paper = standard("rate", {"deviation": "corrected", "rows": rows})
    plain = items_only(JJF1536, recording).items["ahrs_scale_factor"].value
    corrected = calibrated(JJF1536, recording, paper).items["ahrs_scale_factor"].value
    for axis in AXES:
        assert corrected[axis] == pytest.approx((plain[axis] or 0.0) * 1.0003, rel=1e-7)


@settings(max_examples=10, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(coefficients=st.lists(st.floats(-1e-5, 1e-5), min_size=1, max_size=3))
def test_a_polynomial_is_taken_off_whatever_its_shape(ideal_run, coefficients):
    exact = ideal_run(dwell=1.0)
    polynomial = {
        "coefficients": [c / 300.0**n for n, c in enumerate(coefficients)],
        "lowest": 5.0, "highest": 300.0, "U": 1e-5,
    }  # fmt: skip

    def error(rate: float) -> float:
        return sum(c * rate**n for n, c in enumerate(polynomial["coefficients"]))

    paper = standard("rate", {"deviation": "corrected", "polynomials": [polynomial]})
    made = calibrated(JJF2003, on_wrong_table(exact, np.eye(3), error), paper)
    for axis in AXES:
        assert made.items["gyro_scale_factor"].value[axis] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("how", ["corrected", "budgeted"])
def test_u_of_the_rate_is_that_of_a_hand_computation(ideal_run, how):
    """u(K) = Σ ω²·u(ω) / Σ ω²: one error of the table, as large as is stated at each rate."""
    drift = {"per_year": 2e-5, "distribution": "rectangular"}
    paper = standard("rate", {"deviation": how, "k": 2.5, "rows": TABLE, "drift": drift})
    made = calibrated(JJF2003, ideal_run(dwell=1.0), paper)
    years = (MEASURED_ON - CALIBRATED).days / 365.25
    bound = [2 * U / 2.5 + (abs(d) if how == "budgeted" else 0.0) for _, d, U in ROWS]
    at = [math.hypot(b / 2, 2e-5 * years / math.sqrt(3)) for b in bound]
    between = {10.0: max(at[:2]), 50.0: max(at[:2]), 100.0: max(at[1:]), 200.0: max(at[1:])}
    of_rate = between | {300.0: at[2]}
    expected = sum(r**2 * u for r, u in of_rate.items()) / sum(r**2 for r in of_rate)
    (line,) = [
        line for line in made.items["gyro_scale_factor"].budgets["x"].inputs if line.symbol == "ε1"
    ]
    value = made.items["gyro_scale_factor"].value["x"]
    assert line.contribution == pytest.approx(expected * value, rel=1e-4)
    assert line.u == pytest.approx(max(at))
    assert line.source == f"C-9 (T-1): deviation {how}, drift over {years:.2f} a"


def test_drift_grows_with_the_age_of_the_certificate():
    drift = {"per_year": 1e-4, "distribution": "normal"}
    paper = standard("time_base", {
        "deviation": "corrected", "rows": [{"deviation": 1e-5, "U": 2e-5}], "drift": drift,
    })  # fmt: skip
    for days in (0, 365, 1461):
        limit = stated_limits([paper], CALIBRATED + timedelta(days))["time_base"]
        assert limit.half_width == pytest.approx(math.hypot(2e-5, 1e-4 * days / 365.25))


def test_a_drift_since_an_unknown_day_lasts_until_the_certificate_runs_out():
    drift = {"per_year": 1e-4, "distribution": "normal"}
    function = {"deviation": "corrected", "rows": [{"deviation": 0.0, "U": 1e-9}], "drift": drift}
    until = standard("gravity", function, valid_until=date(2028, 2, 29))
    assert stated_limits([until], None)["gravity"].half_width == pytest.approx(2e-4, rel=1e-3)
    with pytest.raises(Unusable, match=r"C-9 \(T-1\) states a drift, and neither"):
        stated_limits([standard("gravity", function)], None)


def test_encoders_are_corrected_axis_by_axis_at_their_angle(simulated):
    """A middle axis that shows 1 mrad too much at 90°, and nothing wrong at 0°."""
    exact, _ = simulated
    rows = [{"axis": axis.name, "at": at, "deviation": 1e-3 if k == 1 and at == 90.0 else 0.0,
             "U": 1e-5}
            for k, axis in enumerate(exact.manifest.station.table_axes or ())
            for at in (-180.0, 0.0, 45.0, 90.0, 135.0, 180.0)]  # fmt: skip
    paper = standard("position", {"deviation": "corrected", "rows": rows})
    made = as_certified(exact, [paper])
    assert exact.table is not None
    assert made.table is not None
    for name, column in exact.table.columns.items():
        moved = column - made.table.columns[name]
        at_90 = np.abs(np.degrees(column) - 90.0) < 1e-6
        assert moved[at_90] == pytest.approx(1e-3 if name.startswith("middle") else 0.0, abs=1e-9)
        assert np.abs(moved[np.abs(np.degrees(column)) < 1e-6]).max() < 1e-9


def test_encoders_that_deviate_by_a_known_function_give_the_truth_once_corrected(simulated):
    """The table stands where it stood, and its inner axis shows 2e-4·sin² of its angle too much.

    With x up or down gravity is then looked for 2e-4 beside x, with y up or down where it is: a
    cross coupling of x and y.
    """
    exact, _ = simulated
    axes = [axis.name for axis in exact.manifest.station.table_axes or ()]
    at = np.arange(-180.0, 181.0, 5.0)
    rows = [
        {"axis": axis, "at": float(x), "U": 1e-6,
         "deviation": 2e-4 * math.sin(math.radians(x)) ** 2 if axis == axes[2] else 0.0}
        for axis in axes
        for x in at
    ]  # fmt: skip
    assert exact.table is not None
    columns = dict(exact.table.columns)
    actual = columns[f"{axes[2]}_angle"]
    columns[f"{axes[2]}_angle"] = actual + 2e-4 * np.sin(actual) ** 2
    wrong = replace(exact, table=replace(exact.table, columns=columns))
    paper = standard("position", {"deviation": "corrected", "rows": rows})
    right, left, corrected = (
        items_only(JOINT, each).items["accel_cross_coupling"].value
        for each in (exact, wrong, as_certified(wrong, [paper]))
    )
    off = max(abs((left[e] or 0.0) - (right[e] or 0.0)) for e in right)
    assert off == pytest.approx(2e-4, rel=0.05)
    for element, value in right.items():
        assert corrected[element] == pytest.approx(value, abs=1e-6)


def test_gravity_and_the_clock_are_corrected(ideal_run):
    exact = ideal_run(dwell=1.0)
    g = exact.manifest.station.gravity_m_s2
    one = {"deviation": "corrected", "rows": [{"deviation": 1e-3, "U": 1e-5}]}
    assert g is not None
    for name in ("accel_scale_factor", "gyro_scale_factor"):
        plain = items_only(JJF2003, exact).items[name].value["x"]
        by_g = calibrated(JJF2003, exact, standard("gravity", one)).items[name].value["x"]
        factor = g / (g - 1e-3) if name == "accel_scale_factor" else 1.0
        assert by_g == pytest.approx(plain * factor, rel=1e-9)
    slower = as_certified(exact, [standard("time_base", one)])
    assert slower.imu.t[-1] == pytest.approx(exact.imu.t[-1] / 1.001)
    ends = (exact.manifest.segments or ())[-1].t_end, (slower.manifest.segments or ())[-1].t_end
    assert ends[1] == pytest.approx(ends[0] / 1.001)


def test_a_rate_beyond_the_certificate_is_refused_whether_corrected_or_not(ideal_run):
    for how in ("corrected", "budgeted"):
        paper = standard("rate", {"deviation": how, "rows": TABLE[:2]})
        with pytest.raises(Unusable) as refused:
            as_certified(ideal_run(dwell=1.0), [paper])
        assert "C-9 (T-1) states the error of rate" in str(refused.value)
        assert "only from 10 to 100 °/s, while segment" in str(refused.value)
        assert "held at 300 °/s" in str(refused.value)


def test_what_the_recording_does_not_show_is_not_corrected_in_silence(ideal_run):
    exact = ideal_run(dwell=1.0)
    rows = [{"at": at, "deviation": 1e-5, "U": 1e-5} for at in (0.0, 360.0)]
    with pytest.raises(Unusable, match="no encoders that it could be taken off"):
        as_certified(exact, [standard("position", {"deviation": "corrected", "rows": rows})])
    of_axis = [row | {"axis": "inner"} for row in TABLE]
    with pytest.raises(Unusable, match="does not show which axis turned"):
        as_certified(exact, [standard("rate", {"deviation": "corrected", "rows": of_axis})])
    unlabelled = replace(exact, manifest=exact.manifest.model_copy(update={"segments": None}))
    with pytest.raises(Unusable, match="no labelled segments"):
        as_certified(unlabelled, [standard("rate", {"deviation": "corrected", "rows": TABLE})])


def test_what_a_laboratory_states_itself_leaves_the_function_alone(ideal_run):
    exact = ideal_run(dwell=1.0)
    paper = standard("rate", {"deviation": "corrected", "rows": TABLE[:2]})
    assert as_certified(exact, [paper], own=("rate",)) is exact


def test_two_functions_of_one_property_are_refused(ideal_run):
    paper = standard("rate", {"deviation": "corrected", "rows": TABLE})
    with pytest.raises(Unusable, match="both state the error of rate"):
        as_certified(ideal_run(dwell=1.0), [paper, paper])
