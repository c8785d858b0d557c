"""What used a measurement standard: runs, results, certificates, and nothing else."""

from collections.abc import Callable
from dataclasses import replace
from datetime import date
from typing import Any

import pytest

from schemas.certificate import Certificate
from schemas.recording import Manifest
from schemas.tolerance import Decision
from storage.catalogue import results, runs
from storage.home import Home
from tests.keep import keep
from tests.table_dcc import ANGLES, RATES, document

TABLE = {"name": "Table", "name_zh": "转台", "serial": "T-7", "accuracy": "1″", "certificate": "C1"}


@pytest.fixture
def add(home, ideal_run, mimucal) -> Callable[..., str]:
    """Keeps and calibrates a run of a day; gives its id."""

    def keep(day: str, gravity: float, **fields: Any) -> str:
        recording = ideal_run(dwell=1.0, gravity=gravity)
        manifest = recording.manifest.model_dump() | {"recorded_at": day} | fields
        again = replace(recording, manifest=Manifest.model_validate(manifest))
        run = runs.add(again, Home(home))[0].id
        assert mimucal("calibrate", run).code == 0
        return run

    return keep


def certified(home: Home, run: str, number: str, **more: Any) -> None:
    kept, day = runs.find(run, home), date(2026, 6, 1)
    fields = {
        "number": number, "state": "issued", "calibrated_on": day, "issued_on": day,
        "due": date(2027, 6, 1), "laboratory": None, "order": None,
        "manifest": runs.load(kept, home).manifest,
        "calibration": results.of_run(kept, home)[-1].calibration,
        "decision": Decision(verdict="inconclusive", rule="simple", document=None, limits=()),
    }  # fmt: skip
    keep(Certificate.model_validate(fields | more), home)


def test_runs_results_and_certificates_of_the_time_are_named_and_no_others(home, add, mimucal):
    before = add("2026-02-28", 9.78, equipment=[TABLE])
    within = add("2026-03-01", 9.79, equipment=[TABLE])
    by_laboratory = add("2026-05-31", 9.80)
    other = add("2026-04-01", 9.81, equipment=[TABLE | {"serial": "T-8", "certificate": "C2"}])
    party = dict.fromkeys(("name", "name_zh", "address", "address_zh"), "L")
    laboratory = {"party": party, "equipment": [TABLE]}
    for number, run in (("A-1", before), ("A-2", within), ("A-4", other)):
        certified(Home(home), run, number)
    certified(Home(home), by_laboratory, "A-3", laboratory=laboratory)
    asked = ("--since", "2026-03-01", "--until", "2026-05-31", "--json")
    for name in ("T-7", "C1"):
        found = mimucal("impact", name, *asked).json
        assert [(r["run"], r["documents"]) for r in found["runs"]] == [
            (within, ["manifest"]), (by_laboratory, ["A-3"]),
        ]  # fmt: skip
        assert {r["run"] for r in found["results"]} == {within, by_laboratory}
        assert [c["number"] for c in found["certificates"]] == ["A-2", "A-3"]
    planned = mimucal("reprocess", "--dry-run", "--equipment", "T-7", *asked).json
    assert planned["runs"] == [within, by_laboratory]
    assert len(mimucal("impact", "test", "--json").json["runs"]) == 4  # by the station


def test_runs_of_an_unknown_day_are_named_apart(add, mimucal):
    dated = add("2026-03-01", 9.79, equipment=[TABLE])
    undated = add("some day", 9.80, equipment=[TABLE])
    asked = ("--since", "2026-03-01", "--until", "2026-05-31")
    found = mimucal("impact", "T-7", *asked, "--json").json
    assert [r["run"] for r in found["runs"]] == [dated]
    assert found["undated"] == [undated]
    assert undated in mimucal("impact", "T-7", *asked).out
    assert mimucal("impact", "T-7", "--json").json["undated"] == []


# The register of standards as a person types it: from a DCC, with checks, with a bad file.


def test_a_dcc_fills_an_entry_of_the_register(home, mimucal, tmp_path):
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


def test_a_failed_check_is_shown_at_once_and_listed(home, mimucal, tmp_path):
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
