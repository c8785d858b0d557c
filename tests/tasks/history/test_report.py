"""The report of a re-processing as files."""

import csv
from functools import cache
from io import StringIO
from xml.etree import ElementTree

from schemas.history import Change, Reprocessing
from tasks.history import report_texts

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


def test_json_table_and_picture_hold_the_same_changes() -> None:
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


def test_what_is_no_longer_determined_stands_apart_from_the_smallest_steps() -> None:
    kept = CHANGE.model_copy(update={"after": 0.25, "in_U": 0.0})
    assert "determined before or now only" in texts_of(CHANGE)["changed.svg"]
    assert "determined" not in report_texts(reprocessing(kept))["changed.svg"]
