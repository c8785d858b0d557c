"""A run that passes by every method, and what is put into it: then it passes by none."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from schemas.calibration import Calibration, Method
from schemas.decision import Decision
from schemas.recording import ACCEL, GYRO, Recording, Stream
from schemas.tolerance import Limit, Tolerance
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.evaluation import evaluation_for
from tasks.conformity import decide
from tasks.run_validity.judge import run_remarks
from tasks.specifications.register import SPECIFICATIONS
from tests.own_limits import as_table_1
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import simulate
from tests.tasks.run_validity.manipulations import DRIFTS, MANIPULATIONS

METHODS: tuple[Method, ...] = ("jjf2003", "joint", "jjf1536")
SAME_EVIDENCE: tuple[tuple[Method, ...], ...] = (("jjf2003", "joint"), ("jjf1536",))
LIMITED = {
    "jjf2003": ("gyro_scale_factor", "accel_scale_factor"),
    "joint": ("gyro_scale_factor", "accel_scale_factor"),
    "jjf1536": ("ahrs_scale_factor",),
}


@cache
def run_of(method: Method) -> Recording:
    """A whole run of the plant, on an Earth that turns; an AHRS on one axis, else three axes.

    Gravity is taken out of what the gyros read: only then do they show the hemisphere.
    """
    procedure = "ahrs" if method == "jjf1536" else "three_axis"
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
    return calibrated(run_of(method), method)


def calibrated(recording: Recording, method: Method) -> Calibration:
    evaluation = evaluation_for(recording, own=as_table_1())
    return calibrate(
        SPECIFICATIONS[method], recording, run="r", code_version="test", evaluation=evaluation
    )


def decided(calibration: Calibration) -> Decision:
    limits = tuple(
        Limit(item=item, unit="1", lower=0.9, upper=1.1) for item in LIMITED[calibration.method]
    )
    return decide(calibration, Tolerance(
        manufacturer="Plant", model="M-tactical", document="d", limits=limits
    ))  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
def test_the_run_as_it_was_made_is_valid_and_passes(method: Method) -> None:
    calibration = calibration_of(method)
    assert calibration.validity.reasons == ()
    assert decided(calibration).verdict == "pass"


@pytest.mark.parametrize("methods", SAME_EVIDENCE, ids=" and ".join)
@pytest.mark.parametrize("name", MANIPULATIONS)
def test_no_manipulated_run_passes(name: str, methods: tuple[Method, ...]) -> None:
    """Judged with the uncertainties of the run that passes, which are smaller."""
    first = methods[0]
    evidence = SPECIFICATIONS[first].gather(MANIPULATIONS[name](run_of(first)))
    for method in methods:
        passing = calibration_of(method)
        remarks = run_remarks(evidence, SPECIFICATIONS[method].conditions, passing.items)
        judged = passing.model_copy(update={"remarks": remarks})
        assert judged.validity.verdict != "valid"
        assert decided(judged).verdict == "inconclusive"


def test_methods_whose_manipulated_runs_are_gathered_once_gather_alike() -> None:
    for first, *others in SAME_EVIDENCE:
        assert all(SPECIFICATIONS[m].gather is SPECIFICATIONS[first].gather for m in others)
    assert sorted(method for methods in SAME_EVIDENCE for method in methods) == sorted(METHODS)


@pytest.mark.parametrize(
    ("name", "method"),
    [
        (name, method)
        for name in DRIFTS
        for method in METHODS
        if method != "jjf1536" or name.startswith(("gyros", "one gyro"))  # that uses no others
    ],
)
def test_no_drifting_run_passes(name: str, method: Method) -> None:
    calibration = calibrated(DRIFTS[name](run_of(method)), method)
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
def test_what_is_not_known_leaves_remarks_and_what_is_wrong_makes_the_run_invalid(
    name: str, verdict: str
) -> None:
    changed: Callable[[Recording], Recording] = MANIPULATIONS[name]
    assert calibrated(changed(run_of("jjf2003")), "jjf2003").validity.verdict == verdict
