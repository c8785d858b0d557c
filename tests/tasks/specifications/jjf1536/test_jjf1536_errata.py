"""The errata of JJF 1536-2015 that test_jjf1536_clauses.py does not already show, entry by entry.

Eq. (2), (16), (17), (A.4) and the second line of (9) are there, the worked examples in
tests/tasks/uncertainty.
"""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from schemas.calibration import Calibration
from schemas.recording import Recording
from tasks.certificate.statements import readings
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.readings import READINGS
from tasks.words import say
from tests.tasks.items_only import items_only

AXES = "xyz"
DEG = float(np.degrees(1.0))
OFF = [(i, j) for i in range(3) for j in range(3) if i != j]
TURNS = 10

Build = Callable[..., Recording]


def result(recording: Recording) -> Calibration:
    return items_only(JJF1536, recording)


@pytest.mark.parametrize(("i", "j"), OFF)
def test_eq_7_8_and_9_divide_by_the_whole_and_give_degrees(ahrs_run, i, j):
    ratio, matrix = 0.001, np.zeros((3, 3))
    matrix[i, j] = ratio
    value = result(ahrs_run(L=matrix)).items["ahrs_misalignment"].value[AXES[i] + AXES[j]]
    forward, back = 360.0 * TURNS * ratio, -360.0 * TURNS * ratio  # degrees
    assert value == pytest.approx(DEG * (forward - back) / (2 * 360 * TURNS), abs=1e-8)
    as_printed = (forward - back) / 2 * 360 * TURNS
    assert abs(as_printed - value) > 1e3


@pytest.mark.parametrize(("i", "j"), OFF)
def test_table_3_mixes_the_indices_and_the_first_is_the_axis_that_reads(ahrs_run, i, j):
    matrix = np.zeros((3, 3))
    matrix[i, j] = 0.001
    value = result(ahrs_run(L=matrix)).items["ahrs_misalignment"].value
    reads, turns = AXES[i], AXES[j]
    assert value[reads + turns] == pytest.approx(0.001 * DEG, abs=1e-8)
    assert value[turns + reads] == pytest.approx(0.0, abs=1e-8)  # had the order been the other


@pytest.mark.parametrize(
    ("reading", "statement"),
    [
        ("jjf1536.turns_divisor", "the whole of 2 × 360 × n; the π of (17) is n"),
        ("jjf1536.l_yz", "L_yx is printed"),
        ("jjf1536.index_order", "The first index is the axis that reads"),
        ("jjf1536.zero_time", "divided by the whole of 4·T"),
    ],
)
def test_the_register_has_the_reading_and_the_certificate_prints_it(ahrs_run, reading, statement):
    assert statement in say(READINGS[reading].text, "en")
    assert say(READINGS[reading].text, "zh")
    assert statement in " ".join(say(each.text, "en") for each in readings(result(ahrs_run())))


@pytest.mark.parametrize(
    ("reading", "statement"),
    [("jjf1536.product", "a product"), ("jjf1536.attitude", "atan2(−T12, T22)")],
)
def test_the_register_has_what_no_value_rests_on(reading, statement):
    assert statement in say(READINGS[reading].text, "en")
    assert say(READINGS[reading].text, "zh")


def test_eq_b4_gives_heading_and_roll_of_b1_in_every_quadrant():
    for heading, pitch, roll in ((0.7, -0.4, 2.1), (-2.9, 0.3, -0.2), (2.0, 1.2, -3.0)):
        T = Rotation.from_euler("ZXY", (heading, pitch, roll)).as_matrix()  # eq. (B.1)
        assert np.arctan2(-T[0, 1], T[1, 1]) == pytest.approx(heading)
        assert np.arctan2(-T[2, 0], T[2, 2]) == pytest.approx(roll)
        assert np.arcsin(T[2, 1]) == pytest.approx(pitch)


def test_the_recalibration_is_due_after_24_months_here_and_12_there():
    assert JJF1536.interval_months == 24
    assert JJF2003.interval_months == 12


def test_room_and_dwell_are_those_of_the_specification_that_is_followed():
    here, there = JJF1536.conditions, JJF2003.conditions
    assert (here.temperature_degc, there.temperature_degc) == ((17.0, 23.0), (15.0, 25.0))
    assert (here.humidity_percent, there.humidity_percent) == ((30.0, 85.0), (20.0, 85.0))
    assert (here.dwell_s, there.dwell_s) == (20.0, 30.0)
