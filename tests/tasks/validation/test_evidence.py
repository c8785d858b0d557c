"""Worked examples, truth recovery and other programs, and that they notice what is wrong."""

from functools import partial

import pytest

from schemas.base import Unusable
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.register import SPECIFICATIONS
from tasks.validation.coverage import EXAMPLES, example_check, recovery_checks, simulate
from tasks.validation.make import independent_checks, make_record, plain_joint
from tests.tasks.items_only import items_only

METHODS = {name: partial(items_only, spec) for name, spec in SPECIFICATIONS.items()}


@pytest.mark.parametrize("item", EXAMPLES)
def test_every_worked_example_comes_out(item):
    assert example_check(item).passed


@pytest.mark.parametrize("method", METHODS)
def test_an_ideal_run_gives_the_truth_back(method):
    checks = recovery_checks(method, METHODS[method], seed=2)
    assert checks
    assert all(check.passed for check in checks.values()), checks


@pytest.mark.parametrize("method", METHODS)
def test_other_programs_find_the_same(method):
    checks = independent_checks(method, METHODS[method], seed=2)
    assert checks
    assert all(check.passed for check in checks.values()), checks


def wrong_by(method: str, part: float):
    """A method whose first element of each item is off by a little."""

    def wrong(*args, **more):
        calibration = METHODS[method](*args, **more)
        items = {}
        for name, item in calibration.items.items():
            first = next(iter(item.value))
            value = {**item.value, first: (item.value[first] or 0.0) + part}
            items[name] = item.model_copy(update={"value": value})
        return calibration.model_copy(update={"items": items})

    return wrong


@pytest.mark.parametrize("method", METHODS)
def test_a_wrong_value_is_noticed(method):
    recovered = recovery_checks(method, wrong_by(method, 1e-4), seed=2)
    still = "gyro_g_sensitivity_without_earth_rotation"  # another field of its item
    assert {name for name, check in recovered.items() if check.passed} <= {still}


def test_a_budget_that_does_not_add_up_is_noticed():
    def wrong(*args, **more):
        calibration = items_only(JJF2003, *args, **more)
        item = calibration.items["gyro_bias"]
        budgets = {e: b.model_copy(update={"u_c": b.u_c * 1.001}) for e, b in item.budgets.items()}
        changed = item.model_copy(update={"budgets": budgets})
        return calibration.model_copy(update={"items": {"gyro_bias": changed}})

    checks = independent_checks("jjf2003", wrong, seed=2)
    assert not checks["gyro_bias"].passed


def test_the_joint_fit_written_anew_gives_the_truth_of_an_ideal_run_back():
    recording, truth = simulate("joint", 4, ideal=True)
    for name, elements in plain_joint(recording).items():
        assert elements == pytest.approx({e: truth[name][e] for e in elements}, abs=1e-9), name


def test_a_study_does_not_begin_without_a_worked_example_for_every_item(monkeypatch):
    monkeypatch.delitem(EXAMPLES, "ahrs_misalignment")
    with pytest.raises(Unusable, match="ahrs_misalignment"):
        make_record({"jjf1536": METHODS["jjf1536"]}, 10, 1, "v", lambda done, of: None)
