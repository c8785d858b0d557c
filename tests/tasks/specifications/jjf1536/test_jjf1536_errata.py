"""The errata of JJF 1536-2015 as the register has them and the certificate prints them.

That a value is what the formula should have said, test_jjf1536_clauses.py shows by moving each
error alone; the worked examples stand in tests/tasks/uncertainty.
"""

import pytest

from schemas.calibration import Calibration
from schemas.recording import Recording
from tasks.certificate.statements import readings
from tasks.specifications.jjf1536 import JJF1536
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.readings import READINGS
from tasks.words import say
from tests.tasks.items_only import items_only


def result(recording: Recording) -> Calibration:
    return items_only(JJF1536, recording)


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


def test_the_recalibration_is_due_after_24_months_here_and_12_there():
    assert JJF1536.interval_months == 24
    assert JJF2003.interval_months == 12


def test_room_and_dwell_are_those_of_the_specification_that_is_followed():
    here, there = JJF1536.conditions, JJF2003.conditions
    assert (here.temperature_degc, there.temperature_degc) == ((17.0, 23.0), (15.0, 25.0))
    assert (here.humidity_percent, there.humidity_percent) == ((30.0, 85.0), (20.0, 85.0))
    assert (here.dwell_s, there.dwell_s) == (20.0, 30.0)
