"""A run that passes by every method, and what is put into it: then it passes by none."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from schemas.calibration import Calibration, Method
from schemas.recording import ACCEL, GYRO, Recording, Stream
from schemas.tolerance import Decision, Limit, Tolerance
from tasks.calibrate.calibrate import calibrate, evaluation_for, without_information
from tasks.conformity import decide
from tasks.run_validity.judge import run_remarks
from tasks.specifications.register import SPECIFICATIONS
from tests.own_limits import as_table_1
from tests.proof.plant.case import Case, EffectCall, Procedure
from tests.proof.plant.simulate import simulate
from tests.tasks.run_validity.manipulations import DRIFTS, MANIPULATIONS

METHODS: tuple[Method, ...] = ("jjf2003", "joint", "jjf1536")
SAME_EVIDENCE: tuple[tuple[Method, ...], ...] = (("jjf2003", "joint"), ("jjf1536",))
EVERY_REMARK = {  # these raise every remark that the others do, which repeat it
    "air for the first 5 %", "supply off", "unit at 85 °C", "no temperature of the unit",
    "gravity 9.71", "no gravity", "a position upside down", "a twentieth lost",
    "no air", "air too warm", "air too humid", "supply falls by a tenth", "no supply",
    "unit warms by 40 K", "latitude of the wrong sign", "no latitude", "heading wrong by 90°",
    "no table, labels 1 % off", "table with a gap of a minute", "encoder jumps by 1 rad",
    "one label of a rate off", "labels 10 s late", "10 % of a gyro off by 5 σ",
    "a channel stands", "gyros shaken in the rests", "two gyros change places",
    "a rest that turns", "a minute lost", "unit half a second early", "table not settled",
}  # fmt: skip
AND_TOGETHER = {  # and these others of them together, on three axes
    "no humidity", "latitude 0°", "latitude 65°", "table without every third row",
    "encoder jumps by 1 rad at the beginning", "encoder jumps by 1 rad for a second",
    "encoder stands", "50 m/s² in the rests", "1 m/s² in one rest", "unit's clock 0.1 % fast",
    "table two seconds late", "2 % of an accelerometer off by 8 σ",
}  # fmt: skip
LIMITED = {
    "jjf2003": ("gyro_scale_factor", "accel_scale_factor"),
    "joint": ("gyro_scale_factor", "accel_scale_factor"),
    "jjf1536": ("ahrs_scale_factor",),
}


def run_of(method: Method) -> Recording:
    """A whole run of the plant, on an Earth that turns; an AHRS on one axis, else three axes."""
    return made_by("ahrs" if method == "jjf1536" else "three_axis")


@cache
def made_by(procedure: Procedure) -> Recording:
    """Gravity is taken out of what the gyros read: only then do they show the hemisphere."""
    earth = EffectCall(name="earth_rotation")
    case = Case(seed=7, grade="tactical", procedure=procedure, rate_hz=10, effects=(earth,))
    made = simulate(case)
    imu, sensitivity = made.recording.imu, np.array(made.sealed["parameters"]["G"])
    gyro = imu.stack(GYRO) - imu.stack(ACCEL) @ sensitivity.T
    return replace(
        made.recording,
        imu=Stream(imu.t, {**imu.columns, **dict(zip(GYRO, gyro.T.copy(), strict=True))}),
        digest="0" * 64,
    )


@cache
def calibration_of(method: Method) -> Calibration:
    return calibrate(
        SPECIFICATIONS[method], run_of(method), run="r", code_version="test",
        evaluation=evaluation_for(run_of(method), own=as_table_1()),
    )  # fmt: skip


def decided(calibration: Calibration) -> Decision:
    limits = tuple(
        Limit(item=item, unit="1", lower=0.9, upper=1.1) for item in LIMITED[calibration.method]
    )
    return decide(calibration, Tolerance(
        manufacturer="Plant", model="M-tactical", document="d", limits=limits
    ))  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
def test_the_run_as_it_was_made_is_valid_and_passes(method):
    calibration = calibration_of(method)
    assert calibration.validity.reasons == ()
    assert decided(calibration).verdict == "pass"


@cache
def judged(name: str, methods: tuple[Method, ...]) -> tuple[Calibration, ...]:
    """With the uncertainties of the run that passes, which are smaller."""
    first, made = methods[0], []
    evidence = SPECIFICATIONS[first].gather(MANIPULATIONS[name](run_of(first)))
    for method in methods:
        passing = calibration_of(method)
        remarks = run_remarks(evidence, SPECIFICATIONS[method].conditions, passing.items)
        made.append(passing.model_copy(update={"remarks": remarks}))
    return tuple(made)


def case(name: str, methods: tuple[Method, ...]) -> Any:
    short = EVERY_REMARK if "jjf1536" in methods else EVERY_REMARK | AND_TOGETHER
    marks = [] if name in short else [pytest.mark.rehearsal]
    return pytest.param(name, methods, marks=marks, id=f"{name}-{' and '.join(methods)}")


@pytest.mark.parametrize(
    ("name", "methods"),
    [case(name, methods) for name in MANIPULATIONS for methods in SAME_EVIDENCE],
)
def test_no_manipulated_run_passes(name, methods):
    for each in judged(name, methods):
        assert each.validity.verdict != "valid"
        assert decided(each).verdict == "inconclusive"


def test_methods_whose_manipulated_runs_are_gathered_once_gather_alike():
    for first, *others in SAME_EVIDENCE:
        assert all(SPECIFICATIONS[m].gather is SPECIFICATIONS[first].gather for m in others)
    assert sorted(method for methods in SAME_EVIDENCE for method in methods) == sorted(METHODS)


@pytest.mark.parametrize(
    ("name", "methods"),
    [
        (name, methods)
        for name in DRIFTS
        for methods in SAME_EVIDENCE
        if "jjf1536" not in methods or name.startswith(("gyros", "one gyro"))  # it uses no others
    ],
)
def test_no_drifting_run_passes(name, methods):
    drifting = DRIFTS[name](run_of(methods[0]))
    evidence, evaluation = (
        SPECIFICATIONS[methods[0]].gather(drifting), evaluation_for(drifting, own=as_table_1())
    )  # fmt: skip
    for method in methods:
        calibration = without_information(SPECIFICATIONS[method], evidence, evaluation)
        assert decided(calibration).verdict != "pass"


@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("air for the first 5 %", "remarks"),
        ("no table", "remarks"),
        ("latitude of the wrong sign", "invalid"),
        ("heading wrong by 90°", "invalid"),
        ("encoder jumps by 1 rad", "invalid"),
        ("10 % off by 5 σ", "invalid"),
        ("50 m/s² in the rests", "invalid"),
        ("unit a second late", "invalid"),
        ("table with a gap of a minute", "invalid"),
    ],
)
def test_what_is_not_known_leaves_remarks_and_what_is_wrong_makes_the_run_invalid(name, verdict):
    assert judged(name, SAME_EVIDENCE[0])[0].validity.verdict == verdict


def test_the_calibration_of_a_manipulated_run_says_that_it_is_invalid():
    late = MANIPULATIONS["unit a second late"](run_of("jjf2003"))
    found = calibrate(SPECIFICATIONS["jjf2003"], late, run="r", code_version="test")
    assert found.validity.verdict == "invalid"
    assert decided(found).verdict == "inconclusive"
