"""The last discrepancy of each run: its findings as rows, its report as written."""

from datetime import datetime
from pathlib import Path
from typing import Any

import sqlalchemy as sql

from schemas.discrepancy import Discrepancy, FindingInBrief, Moved, ReportedFinding
from storage.blobs import blobs_of
from storage.catalogue import database, tables
from storage.catalogue.run_states import LAST_RESULT
from storage.catalogue.runs import Run
from storage.home import Home

FOLDER = "explained"
RUN, UNIT = tables.runs.c, tables.units.c
ANSWER, FOUND, MADE = tables.explained.c, tables.findings.c, tables.outcomes.c


def name_of(digest: str) -> str:
    """Where the report of a recording is kept."""
    return f"{FOLDER}/{digest}.html"


def keep(run: Run, discrepancy: Discrepancy, report: str, at: datetime, home: Home) -> None:
    """Keeps findings and report of a run, in place of earlier ones."""
    blobs, name = blobs_of(home), name_of(run.digest)

    def write(path: Path) -> None:
        path.write_text(report, encoding="utf-8")

    blobs.remove_file(name)
    blobs.keep(name, write)
    with database.changing(home) as connection:
        for table in (tables.findings, tables.explained):
            connection.execute(sql.delete(table).where(table.c.run == run.id))
        row = {
            "run": run.id,
            "at": at,
            "code_version": discrepancy.code_version,
            "verdict": discrepancy.verdict,
        }
        connection.execute(sql.insert(tables.explained).values(row))
        database.add_all_new(connection, tables.findings, [
            {"run": run.id, "number": number} | _row(finding)
            for number, finding in enumerate(discrepancy.findings)
        ])  # fmt: skip


def report_of(run: Run, home: Home) -> bytes | None:
    """The report of a run as HTML; None where none is kept."""
    blobs, name = blobs_of(home), name_of(run.digest)
    if not blobs.exists(name):
        return None
    with blobs.local(name) as path:
        return bytes(path.read_bytes())


def explained_runs(home: Home) -> list[dict[str, Any]]:
    """Each explained run, in order of time: run, station, model, serial, day, at, verdict, validity
    (null: no result), and its findings (`effect`, `share`, `brief`), the largest share first.
    """
    answers = sql.select(
        RUN.id.label("run"), RUN.station, UNIT.model, UNIT.serial, RUN.recorded_on,
        RUN.imported_at, ANSWER.at, ANSWER.verdict, MADE.verdict.label("validity"),
    ).select_from(
        tables.explained.join(tables.runs).join(tables.units)
        .outerjoin(tables.outcomes, MADE.result == LAST_RESULT)
    )  # fmt: skip
    rows = database.rows(home, answers.order_by(RUN.recorded_on, RUN.imported_at, RUN.id))
    runs = {row.run: dict(row._mapping) | {"findings": []} for row in rows}
    asked = sql.select(FOUND.run, FOUND.effect, FOUND.share, FOUND.document)
    for row in database.rows(home, asked.order_by(FOUND.run, FOUND.number)):
        brief = FindingInBrief.model_validate_json(row.document)
        runs[row.run]["findings"].append({"effect": row.effect, "share": row.share, "brief": brief})
    return list(runs.values())


def _row(finding: ReportedFinding) -> dict[str, Any]:
    brief = FindingInBrief(
        title=finding.title, parameters=finding.parameters,
        others=finding.indistinguishable_from, moved=_moved(finding),
    )  # fmt: skip
    return {
        "effect": finding.effect, "share": finding.share,
        "delta_bic": finding.evidence.delta_bic, "document": brief.model_dump_json(),
    }  # fmt: skip


def _moved(finding: ReportedFinding) -> tuple[Moved, ...]:
    """The elements that it changes, the largest change first."""
    moved = [
        Moved(item=each.item, element=each.element, in_U=each.in_U)
        for each in finding.consequences
        if each.in_U
    ]
    return tuple(sorted(moved, key=lambda each: -abs(each.in_U)))
