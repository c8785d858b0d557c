"""U is never smaller than the limits of the laboratory's own equipment allow.

An error at its limit moves a result by an amount that a line of mechanics gives: a table that
turns faster by ε makes every scale factor larger by ε·K, an axis that leans by α reads K·sin α of
the rate about another one, gravity that is off by δ makes an accelerometer's K larger by K·δ/g.
"""

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tasks.calibrate.calibrate import evaluation_for, without_information
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.jjf1536.evidence import AhrsEvidence
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.joint import JOINT
from tasks.validation.coverage import simulate
from tests.own_limits import ARCSECOND, as_table_1

AXES = "xyz"
SHOWN = 1 - 1e-9  # rounding


@pytest.fixture(scope="module")
def evidence(ideal_run) -> ClauseEvidence:
    return JJF2003.gather(ideal_run(dwell=1.0, noise=1e-6))


@pytest.fixture(scope="module")
def ahrs_evidence() -> AhrsEvidence:
    return JJF1536.gather(simulate("jjf1536", 3)[0])


@pytest.mark.parametrize("specification", [JJF2003, JOINT], ids=["clauses", "joint"])
@settings(max_examples=8, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    rate=st.floats(1e-7, 1e-2),
    fixture=st.floats(0.1 * ARCSECOND, 600 * ARCSECOND),
    gravity=st.floats(1e-6, 1e-1),
)
def test_an_error_at_its_limit_stays_within_u(evidence, specification, rate, fixture, gravity):
    own = as_table_1(rate=rate, fixture=fixture)
    own["gravity"] = own["rate"].model_copy(update={"half_width": gravity})
    evaluation = evaluation_for(evidence.recording, own=own)
    items = without_information(specification, evidence, evaluation).items
    local = evidence.recording.manifest.station.gravity_m_s2
    for axis in AXES:
        gyro, accel = items["gyro_scale_factor"], items["accel_scale_factor"]
        assert gyro.U[axis] >= rate * abs(gyro.value[axis]) * SHOWN
        assert accel.U[axis] >= gravity / local * abs(accel.value[axis]) * SHOWN
        for other in AXES.replace(axis, ""):
            lean = math.sin(fixture) * abs(gyro.value[axis])
            assert items["gyro_cross_coupling"].U[axis + other] >= lean * SHOWN


@settings(max_examples=6, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    rate=st.floats(1e-7, 1e-2),
    fixture=st.floats(0.1 * ARCSECOND, 600 * ARCSECOND),
    shape=st.sampled_from(["normal", "rectangular"]),
)
def test_the_same_holds_of_a_unit_that_accumulates_angles(ahrs_evidence, rate, fixture, shape):
    own = as_table_1(rate=rate, fixture=fixture)
    own = {name: limit.model_copy(update={"distribution": shape}) for name, limit in own.items()}
    evaluation = evaluation_for(ahrs_evidence.recording, own=own)
    items = without_information(JJF1536, ahrs_evidence, evaluation).items
    for axis in AXES:
        scale = items["ahrs_scale_factor"]
        assert scale.U[axis] >= rate * abs(scale.value[axis]) * SHOWN
        for other in AXES.replace(axis, ""):
            lean = math.degrees(math.sin(fixture)) * abs(scale.value[axis])
            assert items["ahrs_misalignment"].U[axis + other] >= lean * SHOWN
