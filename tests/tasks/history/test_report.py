"""The report of a re-processing as files."""

import csv
from functools import cache
from io import StringIO
from typing import Any
from xml.etree import ElementTree

import pytest

from schemas.calibration import Calibration, Item
from schemas.history import Change, Reprocessing
from schemas.text import Remark
from schemas.tolerance import Tolerance
from tasks.history import difference, report_texts

# What moved between two results: exactly that, in units of U, and the verdicts it flips.


def result(x: float | None = 0.25, U: float | None = 0.02, **changes: Any) -> Calibration:
    u = None if U is None else U / 2
    item = Item(
        unit="deg/s", clause="7.2.2",
        value={"x": x, "y": 0.1, "z": 0.1}, u={"x": u, "y": 0.01, "z": 0.01},
        U={"x": U, "y": 0.02, "z": 0.02},
    )  # fmt: skip
    fields = {
        "recording_id": "one", "run": "r1", "digest": "0", "method": "jjf2003",
        "code_version": "1", "procedure": "p", "settings": {}, "items": {"gyro_bias": item},
        "unavailable": {},
    }  # fmt: skip
    return Calibration.model_validate(fields | changes)


@pytest.fixture
def limits() -> Tolerance:
    return Tolerance.model_validate({
        "format": "mimu-tolerance/1", "manufacturer": "Maker", "model": "U", "document": "D1",
        "limits": [{"item": "gyro_bias", "unit": "deg/s", "magnitude": 0.3}],
    })  # fmt: skip


def test_equal_results_of_other_code_differ_in_nothing(limits):
    found = difference(result(), result(code_version="2"), limits)
    assert (found.changed, found.flips) == ((), ())


def test_a_moved_value_is_the_only_change_and_is_counted_in_its_uncertainty_before():
    (change,) = difference(result(), result(0.29, 0.08)).changed
    assert (change.run, change.item, change.element, change.unit) == (
        "r1", "gyro_bias", "x", "deg/s",
    )  # fmt: skip
    assert (change.before, change.after, change.U_before, change.U_after) == (
        0.25, 0.29, 0.02, 0.08,
    )  # fmt: skip
    assert change.in_U == pytest.approx(2.0)


def test_what_moves_by_less_than_the_stated_share_of_u_is_no_change():
    for x, U in ((0.25 + 1.4e-11 * 0.02, 0.02), (0.25 + 0.0099 * 0.02, 0.02), (0.25, 0.020_19)):
        assert difference(result(), result(x, U)).changed == ()
    for x, U in ((0.25 + 0.0101 * 0.02, 0.02), (0.25, 0.020_21)):
        assert len(difference(result(), result(x, U)).changed) == 1
    (change,) = difference(result(U=None), result(0.25 + 1e-12, None)).changed  # of unknown U
    assert change.in_U is None


def test_a_value_that_is_no_longer_determined_has_no_distance():
    (change,) = difference(result(), result(None, None)).changed
    assert (change.before, change.after, change.in_U) == (0.25, None, None)


def test_an_item_that_is_new_is_a_change_of_each_of_its_elements():
    found = difference(result(items={}), result())
    assert [change.element for change in found.changed] == ["x", "y", "z"]
    assert {change.before for change in found.changed} == {None}


def test_a_value_that_leaves_its_limits_flips_its_element_and_the_unit(limits):
    flips = difference(result(), result(0.35), limits).flips
    assert [(f.about, f.element, f.before, f.after) for f in flips] == [
        ("unit", None, "pass", "fail"),
        ("element", "x", "pass", "fail"),
    ]


def test_a_run_that_is_invalid_now_flips_the_run():
    remark = Remark(code="stuck", en="It stood still.", zh="停。", run="invalid")
    (flip,) = difference(result(), result(remarks=(remark,))).flips
    assert (flip.about, flip.before, flip.after) == ("run", "valid", "invalid")


CHANGE = Change(
    run="r1", method="jjf2003", item="gyro_bias", element="x", unit="deg/s", before=0.25,
    after=None, U_before=0.02, U_after=None, in_U=None,
)  # fmt: skip


def reprocessing(*changed: Change) -> Reprocessing:
    return Reprocessing(
        code_version="2", circumstances="c", runs=1, done=1, done_before=0, failed=0,
        unchanged=0, changed=changed, seconds=1.0,
    )  # fmt: skip


@cache
def texts_of(*changed: Change) -> dict[str, str]:
    return report_texts(reprocessing(*changed))


def test_json_table_and_picture_hold_the_same_changes():
    moved = CHANGE.model_copy(update={"after": 0.5, "in_U": 12.5, "element": "y"})
    report = reprocessing(CHANGE, moved)
    texts = report_texts(report)
    assert Reprocessing.model_validate_json(texts["report.json"]) == report
    rows = list(csv.DictReader(StringIO(texts["changed.csv"])))
    assert [(row["element"], row["after"], row["in_U"]) for row in rows] == [
        ("x", "", ""),
        ("y", "0.5", "12.5"),
    ]
    ElementTree.fromstring(texts["changed.svg"])
    assert "bias" in texts["changed.svg"]


def test_what_is_no_longer_determined_stands_apart_from_the_smallest_steps():
    kept = CHANGE.model_copy(update={"after": 0.25, "in_U": 0.0})
    assert "determined before or now only" in texts_of(CHANGE)["changed.svg"]
    assert "determined" not in report_texts(reprocessing(kept))["changed.svg"]
