"""The report of a re-processing as files."""

import csv
from pathlib import Path
from xml.etree import ElementTree

from schemas.history import Change, Reprocessing
from tasks.history import write_report

CHANGE = Change(
    run="r1", method="jjf2003", item="gyro_bias", element="x", unit="deg/s", before=0.25,
    after=None, U_before=0.02, U_after=None, in_U=None,
)  # fmt: skip


def reprocessing(*changed: Change) -> Reprocessing:
    return Reprocessing(
        code_version="2", circumstances="c", runs=1, done=1, done_before=0, failed=0,
        unchanged=0, changed=changed, seconds=1.0,
    )  # fmt: skip


def test_json_table_and_picture_hold_the_same_changes(tmp_path: Path) -> None:
    moved = CHANGE.model_copy(update={"after": 0.5, "in_U": 12.5, "element": "y"})
    report = reprocessing(CHANGE, moved)
    write_report(report, tmp_path)
    text = (tmp_path / "report.json").read_text(encoding="utf-8")
    assert Reprocessing.model_validate_json(text) == report
    with (tmp_path / "changed.csv").open(encoding="utf-8", newline="") as table:
        rows = list(csv.DictReader(table))
    assert [(row["element"], row["after"], row["in_U"]) for row in rows] == [
        ("x", "", ""),
        ("y", "0.5", "12.5"),
    ]
    picture = (tmp_path / "changed.svg").read_text(encoding="utf-8")
    ElementTree.fromstring(picture)
    assert "bias" in picture


def test_a_report_without_changes_has_a_picture_that_says_so(tmp_path: Path) -> None:
    write_report(reprocessing(), tmp_path)
    assert "nothing moved" in (tmp_path / "changed.svg").read_text(encoding="utf-8")
