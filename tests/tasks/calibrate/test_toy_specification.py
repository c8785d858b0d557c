"""A specification made up in this file goes through calibration, verdict and layout."""

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.recording import AXES, GYRO, Recording
from schemas.tolerance import Limit, Tolerance
from tasks.calibrate.calibrate import calibrate
from tasks.certificate.results import sections
from tasks.conformity import decide
from tasks.segments.find import Conditions
from tasks.specifications.estimate import (
    DEG,
    ClauseResult,
    ItemDefinition,
    ItemEstimate,
    Section,
    Specification,
    linear_estimate,
    scaled,
)
from tasks.specifications.evidence import ClauseEvidence, gather
from tasks.uncertainty.equipment import UNKNOWN, Equipment
from tasks.words import say

RESTING_RATE = ItemDefinition("gyro_bias", "b", "r{e}", "deg/s", AXES)


def check(recording: Recording) -> None:
    if not all(name in recording.imu.columns for name in GYRO):
        raise Unusable(f"{recording.manifest.recording_id}: the toy needs gyro_* columns")


def resting_rate(evidence: ClauseEvidence, equipment: Equipment) -> ClauseResult:
    """The mean reading of each gyro over all rests."""
    rests = evidence.of_kind("static")
    weights = np.isin(np.arange(len(evidence.segments)), rests) / len(rests)
    elements = {axis: linear_estimate(evidence, i, weights) for i, axis in enumerate(AXES)}
    return ClauseResult({"gyro_bias": ItemEstimate(scaled(elements, DEG), "toy, 1")})


TOY = Specification(
    method="jjf2003",
    standard="other",
    procedure="toy",
    items=(RESTING_RATE,),
    required=("gyro_bias",),
    conditions=Conditions(40.0, "2", 1e-3, "3", (10.0, 30.0), (10.0, 90.0), "4"),
    interval_months=6,
    layout=(Section("biases", ("gyro_bias",)),),
    equipment=UNKNOWN,
    equipment_source="none",
    check=check,
    gather=gather,
    estimate=resting_rate,
)


def tolerance(limit: float) -> Tolerance:
    return Tolerance(
        manufacturer="m", model="n", document="d",
        limits=(Limit(item="gyro_bias", unit="deg/s", lower=-limit, upper=limit),),
    )  # fmt: skip


def test_a_toy_has_values_uncertainties_and_its_own_conditions(ideal_run):
    bias = [0.001, -0.002, 0.003]
    made = calibrate(TOY, ideal_run(Bg=bias), run="r", code_version="v")
    assert list(made.items) == ["gyro_bias"]
    item = made.items["gyro_bias"]
    assert list(item.value.values()) == pytest.approx([DEG * b for b in bias], abs=1e-6)
    assert all(u > 0.0 for u in item.U.values())
    assert "40 s per point required by 2" in " ".join(r.en for r in made.remarks)
    assert made.procedure == "toy"


def test_a_toy_is_decided_on(ideal_run):
    made = calibrate(TOY, ideal_run(Bg=[0.01, 0.0, 0.0]), run="r", code_version="v")
    assert decide(made, tolerance(0.1)).verdict == "fail"
    assert all(d.verdict == "pass" for d in decide(made, tolerance(1.0)).limits)


def test_a_toy_is_laid_out_for_a_certificate_in_every_language(ideal_run):
    made = calibrate(TOY, ideal_run(Bg=[0.01, 0.0, 0.0]), run="r", code_version="v")
    (section,) = sections(made, decide(made, tolerance(1.0)), TOY)
    assert [say(section.title, language) for language in ("en", "zh")] == ["Biases", "零偏"]
    (group,) = section.groups
    assert [say(row.name, "en") for row in group.rows] == [
        f"Bias of the {axis} gyro" for axis in "XYZ"
    ]
    assert [f"{row.letter}_{row.sub}" for row in group.rows] == ["b_rx", "b_ry", "b_rz"]
    assert all(row.value and row.U and row.limits for row in group.rows)
