"""The line as a store: rows in bulk, by the functions that make them of a single run."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from datetime import timedelta
from hashlib import sha256
from typing import Any

import sqlalchemy as sql

from schemas.calibration import Calibration
from schemas.recording import Manifest
from storage.catalogue import database, equipment, lineage, result_rows, tables
from storage.catalogue.results import result_id
from storage.catalogue.runs import unit_id
from storage.formats.manifest import MANIFEST
from storage.home import Home
from tests.proof.line.draw import MODELS, Line, LineUnit, station_name
from tests.proof.line.papers import (
    certificate_of,
    manifest_of_run,
    row_of,
    tolerance_of,
    turntables,
)
from tests.proof.line.physics import measured_by_grade
from tests.proof.line.recorded import Recorded, as_recorded
from tests.proof.line.visits import LineRun, runs_of

Rows = dict[str, list[dict[str, Any]]]
UNCERTIFIED = 0.03  # of the runs
SECONDS, ROWS = 235.0, 4_700


@dataclass
class _Numbers:
    """Serial numbers of certificates by year."""

    last: dict[int, int] = field(default_factory=dict)

    def next(self, year: int) -> str:
        self.last[year] = self.last.get(year, 0) + 1
        return f"LINE-{year}-{self.last[year]:05d}"


def fill(home: Home, line: Line, recorded: Recorded, progress: Callable[[int, int], None]) -> None:
    """Makes the store of a line in a home. recorded: how many runs have a recording."""
    home.tolerances.mkdir(parents=True)
    home.certificates.mkdir()
    for model, _ in MODELS:
        text = tolerance_of(model).model_dump_json(exclude_none=True)
        (home.tolerances / f"{model}.json").write_text(text, encoding="utf-8")
    first, *later = turntables()
    equipment.add(first, home, "Wang Li")
    for renewed in later:
        equipment.renew(renewed, home, "Wang Li")
    numbers, measured, done = _Numbers(), measured_by_grade(line), 0
    for unit in line.units:
        tolerance = tolerance_of(MODELS[unit.model][0])
        made = []
        for run in runs_of(line, unit, measured, tolerance):
            made.append(as_recorded(line, unit, run, tolerance, recorded, home))
            done += 1
            progress(done, line.runs)
        _keep(home, unit, made, numbers)


def _keep(home: Home, unit: LineUnit, made: list[LineRun], numbers: _Numbers) -> None:
    """All of a unit in one transaction; what the recorded runs have already stays."""
    rows: Rows = {
        name: []
        for name in (
            "runs",
            "results",
            "elements",
            "outcomes",
            "equipment",
            "certificates",
            "decisions",
        )
    }
    with database.changing(home) as connection:
        for run in made:
            manifest = manifest_for(unit, run)
            number = unit_id(connection, manifest.unit)
            _add(rows, home, unit, run, manifest, number, numbers)
        for name, some in rows.items():
            database.add_all_new(connection, tables.metadata.tables[name], some)
        for row in rows["runs"]:  # those that were imported today were imported long ago
            then = sql.update(tables.runs).where(tables.runs.c.id == row["id"])
            connection.execute(then.values(imported_at=row["imported_at"]))


def manifest_for(unit: LineUnit, run: LineRun) -> Manifest:
    """The manifest of a run of which there is no recording."""
    return Manifest.model_validate({
        "format": "mimu-recording/1", "standard": "JJF 2003-2022",
        "station": {"id": station_name(run.station), "latitude_deg": 39.9, "gravity_m_s2": 9.8015},
        **manifest_of_run(unit, run),
    })  # fmt: skip


def _add(
    rows: Rows, home: Home, unit: LineUnit, run: LineRun, manifest: Manifest, key: int,
    numbers: _Numbers,
) -> None:  # fmt: skip
    calibration = named(run, manifest)
    run = run.model_copy(update={"calibration": calibration})
    document, taken_in = calibration.model_dump_json(), run.at + timedelta(hours=1)
    result = result_id(None, document)
    rows["runs"].append({
        "id": calibration.run, "digest": calibration.digest,
        "recording_id": calibration.recording_id, "unit": key, "standard": manifest.standard,
        "imported_at": taken_in, "seconds": SECONDS, "rows": ROWS, **lineage.provenance(manifest),
    })  # fmt: skip
    rows["results"].append({
        "id": result, "run": calibration.run, "method": calibration.method,
        "code_version": calibration.code_version, "made_at": taken_in, "document": document,
    })  # fmt: skip
    rows["elements"] += [{"result": result} | row for row in result_rows.elements_of(calibration)]
    outcome = result_rows.outcome_of(calibration)
    rows["outcomes"].append({"result": result, "made_at": taken_in} | outcome)
    rows["equipment"] += [
        {"run": calibration.run, "document": lineage.MANIFEST, **used.model_dump()}
        for used in lineage.equipment_of(manifest)
    ]
    _keep_manifest(home, calibration.digest, manifest)
    is_invalid = calibration.validity.verdict == "invalid"
    if not is_invalid and (run.number * 0.618 + unit.number * 0.414) % 1.0 > UNCERTIFIED:
        issued = numbers.next(run.at.year) if run.is_last else f"draft-{calibration.run[:8]}"
        certificate = certificate_of(unit, run, manifest, issued)
        rows["certificates"].append(row_of(certificate, run, result, key))
        rows["decisions"] += [
            {"certificate": issued} | row for row in result_rows.decisions_of(run.decision)
        ]
        text = certificate.model_dump_json()
        (home.certificates / f"{issued}.json").write_text(text, encoding="utf-8")


def named(run: LineRun, manifest: Manifest) -> Calibration:
    """The calibration with the names of its run; that of a recorded run has them."""
    if run.calibration.recording_id == manifest.recording_id:
        return run.calibration
    digest = sha256(f"{manifest.recording_id} at {manifest.station.id}".encode()).hexdigest()
    names = {"run": f"r{digest[:12]}", "digest": digest, "recording_id": manifest.recording_id}
    return run.calibration.model_copy(update=names)


def _keep_manifest(home: Home, digest: str, manifest: Manifest) -> None:
    folder = home.columns / digest
    if not folder.exists():
        folder.mkdir(parents=True)
        text = manifest.model_dump_json(exclude_none=True)
        (folder / MANIFEST).write_text(text, encoding="utf-8")


def recorded_runs(home: Home) -> Iterator[str]:
    """The ids of runs of which there is a recording, in the order of time."""
    kept = {path.stem for path in home.raw.glob("*.mcap")}
    asked = sql.select(tables.runs.c.id, tables.runs.c.digest).order_by(tables.runs.c.recorded_on)
    yield from (row.id for row in database.rows(home, asked) if row.digest in kept)
