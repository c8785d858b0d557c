"""Coverage is counted right, and small studies run through every method."""

import os
from functools import partial

import numpy as np
import pytest

from schemas.calibration import Calibration
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.register import SPECIFICATIONS
from tasks.validation.coverage import coverage_check, interval_of_share, simulate, study, summarise
from tests.tasks.items_only import items_only

METHODS = {name: partial(items_only, spec) for name, spec in SPECIFICATIONS.items()}


def drawn(scale: float, units: int) -> list:
    random = np.random.default_rng(1)
    return [
        {"item": {e: (scale * random.normal(), 1.0, 1.96, 2.0) for e in "xyz"}}
        for _ in range(units)
    ]


def test_errors_as_large_as_stated_are_covered():
    found = summarise(drawn(1.0, 2000))["item"]
    assert found.rms_z == pytest.approx(1.0, abs=0.05)
    assert (found.units, found.elements) == (2000, 6000)
    assert coverage_check(found).passed


def test_intervals_that_are_too_short_are_no_evidence():
    assert not coverage_check(summarise(drawn(1.3, 2000))["item"]).passed


def test_intervals_that_are_too_long_are_said_to_be():
    check = coverage_check(summarise(drawn(0.7, 2000))["item"])
    assert check.passed
    assert "larger than necessary" in check.en


def test_a_few_units_are_no_evidence():
    assert not coverage_check(summarise(drawn(1.0, 1999))["item"]).passed


def test_wilson_interval_is_the_published_one():
    # Newcombe, Statist. Med. 17, 1998, table I: 81 of 263 gives 0.2553 to 0.3662.
    assert interval_of_share(81 / 263, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert interval_of_share(0.0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)


def test_a_study_counts_every_unit_of_every_method(monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: 1)  # a second process would import all again
    reports = []
    found = study(METHODS, 2, 1, lambda done, total: reports.append((done, total)))
    assert reports[-1] == (6, 6)
    assert set(found) == set(METHODS)
    for items in found.values():
        assert all(coverage.units == 2 for coverage in items.values())
    assert set(found["jjf1536"]) == {"ahrs_scale_factor", "ahrs_zero_offset", "ahrs_misalignment"}
    assert found["jjf2003"]["gyro_g_sensitivity"].elements == 18


def test_a_method_that_states_too_little_is_found_out():
    recording, truth = simulate("jjf2003", 3)
    calibration: Calibration = items_only(JJF2003, recording)
    item = calibration.items["gyro_cross_coupling"]
    errors = [abs(item.value[e] - t) for e, t in truth["gyro_cross_coupling"].items()]
    assert max(errors) > 5.0 * 1e-6  # a hundredth of the stated u would not hold it
    assert max(errors) < 4.0 * max(u for u in item.u.values() if u)
