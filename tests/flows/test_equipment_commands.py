"""The register of standards as a person types it: from a DCC, with checks, with a bad file."""

import json
from pathlib import Path

from tests.table_dcc import ANGLES, RATES, document


def test_a_dcc_fills_an_entry_of_the_register(home: Path, mimucal, tmp_path: Path) -> None:
    dcc, entry = tmp_path / "table.xml", tmp_path / "table.json"
    dcc.write_text(document(RATES, ANGLES), encoding="utf-8")
    imported = mimucal("equipment", "import", dcc, "corrected", "--out", entry)
    assert (imported.code, imported.out.splitlines()[:2]) == (
        0, ["rate: 2 rows (every axis)", "position: 3 rows (every axis)"],
    )  # fmt: skip
    assert mimucal("equipment", "add", entry, "--by", "Li").code == 0
    (listed,) = mimucal("equipment", "list", "--json").json["equipment"]
    assert (listed["serial"], listed["certificate"]) == ("TT-07", "CNAS 2026-117")
    assert [row["at"] for row in listed["functions"]["rate"]["rows"]] == [10.0, 100.0]
    assert "rate, position" in mimucal("equipment", "list").out


def test_a_failed_check_is_shown_at_once_and_listed(home: Path, mimucal, tmp_path: Path) -> None:
    dcc, entry = tmp_path / "table.xml", tmp_path / "table.json"
    dcc.write_text(document(RATES), encoding="utf-8")
    mimucal("equipment", "import", dcc, "budgeted", "--out", entry)
    mimucal("equipment", "add", entry, "--by", "Li")
    asked = ("equipment", "check", "TT-07", "--what", "rate", "--limit", "1e-5", "--by", "Li")
    assert "passed" in mimucal(*asked, "--result", "1e-5").out
    assert "CHECK FAILED" not in mimucal("equipment", "list").out
    assert "FAILED: nothing passes" in mimucal(*asked, "--result", "-2e-5").out
    assert "CHECK FAILED" in mimucal("equipment", "list").out
    nobody = mimucal("equipment", "check", "TT-8", *asked[3:], "--result", "0")
    assert (nobody.code, "TT-8 is not in the register" in nobody.err) == (2, True)
    no_number = mimucal(*asked, "--result", "nan")
    assert (no_number.code, "the check of TT-07: result" in no_number.err) == (2, True)


def test_a_table_that_is_none_is_refused_by_file_field_and_value(
    home: Path, mimucal, tmp_path: Path
) -> None:
    entry = {"name": "T", "name_zh": "T", "serial": "1", "accuracy": "", "certificate": "C"}
    row = {"at": 10.0, "deviation": 0.0, "U": 1e-5}
    path = tmp_path / "bad.json"
    for rows, sentence in (
        ([], "equipment.0.functions.rate: give either rows or polynomials"),
        ([row, row], "row at = 10 follows at = 10"),
        ([row | {"U": -1.0}], "equipment.0.functions.rate.rows.0.U"),
    ):
        functions = {"rate": {"deviation": "corrected", "rows": rows}}
        path.write_text(json.dumps({"equipment": [entry | {"functions": functions}]}))
        refused = mimucal("equipment", "add", path, "--by", "Li")
        assert refused.code == 2
        assert str(path) in refused.err
        assert sentence in refused.err
