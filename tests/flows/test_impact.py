"""What used a measurement standard: runs, results, certificates, and nothing else."""

from collections.abc import Callable
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import pytest

from schemas.certificate import Certificate
from schemas.decision import Decision
from schemas.recording import Manifest, Recording
from storage.catalogue import results, run_index, runs
from storage.home import Home
from tests.keep import keep

TABLE = {"name": "Table", "name_zh": "转台", "serial": "T-7", "accuracy": "1″", "certificate": "C1"}


@pytest.fixture
def add(home: Path, ideal_run: Callable[..., Recording], mimucal) -> Callable[..., str]:
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
    kept, day = run_index.find(run, home), date(2026, 6, 1)
    fields = {
        "number": number, "state": "issued", "calibrated_on": day, "issued_on": day,
        "due": date(2027, 6, 1), "laboratory": None, "order": None,
        "manifest": runs.load(kept, home).manifest,
        "calibration": results.of_run(kept, home)[-1].calibration,
        "decision": Decision(verdict="inconclusive", rule="simple", document=None, limits=()),
    }  # fmt: skip
    keep(Certificate.model_validate(fields | more), home)


def test_runs_results_and_certificates_of_the_time_are_named_and_no_others(
    home: Path, add, mimucal
) -> None:
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


def test_runs_of_an_unknown_day_are_named_apart(add, mimucal) -> None:
    dated = add("2026-03-01", 9.79, equipment=[TABLE])
    undated = add("some day", 9.80, equipment=[TABLE])
    asked = ("--since", "2026-03-01", "--until", "2026-05-31")
    found = mimucal("impact", "T-7", *asked, "--json").json
    assert [r["run"] for r in found["runs"]] == [dated]
    assert found["undated"] == [undated]
    assert undated in mimucal("impact", "T-7", *asked).out
    assert mimucal("impact", "T-7", "--json").json["undated"] == []
