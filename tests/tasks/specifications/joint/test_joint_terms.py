"""A term appended to the joint method's list is fitted, and the truth comes out."""

from dataclasses import replace

import numpy as np
import pytest
from test_zero_correction import patent_run, unit

from schemas.recording import AXES, Recording
from tasks.model.term import Term
from tasks.model.terms.environment import TEMPERATURE_BIAS
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.standard import ACCEL_BIAS, ACCEL_MATRIX, GYRO_TERMS, STANDARD_TERMS
from tasks.specifications.evidence import gather
from tasks.specifications.joint.solution import Joint, segment_motion, solve_jointly
from tasks.uncertainty.equipment import JJF2003

CREEP = (2e-4, -1e-4, 3e-4, 0.01, 0.02, -0.03)  # per kelvin
ARM = np.array([0.012, -0.018, 0.007])


def with_added(recording: Recording, added: np.ndarray) -> Recording:
    """The recording with the same reading (segments, 6) more in all samples of a segment."""
    columns = dict(recording.imu.columns)
    for n, segment in enumerate(recording.manifest.segments or ()):
        rows = recording.imu.rows(segment.t_start, segment.t_end)
        for name, value in zip(columns, added[n], strict=True):
            columns[name][rows] += value
    return recording


def solved(recording: Recording, terms: tuple[Term, ...], temperature: np.ndarray) -> Joint:
    evidence = gather(recording)
    motion = segment_motion(evidence)
    mean = replace(motion.mean, recorded={"temperature": temperature})
    return solve_jointly(evidence, replace(motion, mean=mean), JJF2003, terms)


def off(joint: Joint, name: str, true: np.ndarray) -> np.ndarray:
    """(value − truth)/u of a term's parameters, by their standard uncertainty by noise."""
    found = list(joint.estimates[name].values())
    u = [np.hypot.reduce([line.quantity.u * line.sensitivity for line in e.lines]) for e in found]
    return (np.array([e.value for e in found]) - true) / u


def test_a_temperature_term_is_estimated_beside_the_standards():
    planted, recording = unit(), patent_run(unit())
    count = len(recording.manifest.segments or ())
    temperature = 25.0 + 10.0 * np.random.default_rng(5).random(count)
    with_added(recording, np.outer(temperature - 25.0, CREEP))
    joint = solved(recording, (*STANDARD_TERMS, TEMPERATURE_BIAS), temperature)
    assert np.abs(off(joint, "temperature_bias", np.array(CREEP))).max() < 4.0
    assert np.abs(off(joint, "gyro_bias", planted["Bg"])).max() < 4.0
    assert np.abs(off(joint, "accel_bias", planted["Ba"])).max() < 4.0
    assert np.abs(off(joint, "gyro_matrix", planted["Kg"].ravel())).max() < 4.0


def test_a_lever_arm_in_three_channels_has_one_set_of_parameters():
    planted = {**unit(), "P": np.zeros((3, 3))}
    recording = patent_run(planted)
    rates = np.array([
        np.radians(s.rate_deg_s or 0.0) * np.eye(3)[AXES.index(s.axis or "x")]
        for s in recording.manifest.segments or ()
    ])  # fmt: skip
    centripetal = np.cross(rates, np.cross(rates, ARM)) @ planted["Ka"].T
    with_added(recording, np.hstack([np.zeros_like(centripetal), centripetal]))
    terms = (*GYRO_TERMS, ACCEL_MATRIX, ACCEL_BIAS, LEVER_ARM)
    joint = solved(recording, terms, np.zeros(len(rates)))
    found = np.array([estimate.value for estimate in joint.estimates["lever_arm"].values()])
    assert found == pytest.approx(ARM, abs=2e-5)
    assert np.abs(off(joint, "lever_arm", ARM)).max() < 4.0
    assert np.abs(off(joint, "accel_matrix", planted["Ka"].ravel())).max() < 4.0


def test_what_the_segments_do_not_tell_apart_is_not_determined():
    """At one temperature throughout, its bias cannot be told from the unit's."""
    recording = patent_run(unit())
    steady = np.full(len(recording.manifest.segments or ()), 31.0)
    joint = solved(recording, (*STANDARD_TERMS, TEMPERATURE_BIAS), steady)
    for name in ("temperature_bias", "gyro_bias", "accel_bias"):
        assert not any(e.determined for e in joint.estimates[name].values()), name
    for name in ("gyro_matrix", "gyro_g_sensitivity", "accel_matrix"):
        assert all(e.determined for e in joint.estimates[name].values()), name


def test_a_lever_arm_shows_in_gyros_that_feel_acceleration():
    """Beside the rate sensitivity, which says as much of the accelerometers as an arm does."""
    joint = solved(patent_run(unit()), (*STANDARD_TERMS, LEVER_ARM), np.zeros(54))
    assert all(e.determined for e in joint.estimates["lever_arm"].values())
    assert np.abs(off(joint, "lever_arm", np.zeros(3))).max() < 4.0
