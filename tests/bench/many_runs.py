"""A catalogue of ten thousand runs with made-up outcomes, for what only reads the catalogue."""

import hashlib
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np
import sqlalchemy as sql

from storage.catalogue import database, tables
from storage.home import Home

RUNS, UNITS, STATIONS = 10_000, 200, 6
FIRST, EVERY = datetime(2023, 11, 1, tzinfo=UTC), timedelta(hours=2.6)
DOCUMENT = "{}" + " " * 6_000
VERDICTS, VALIDITY = ("pass", "fail", "inconclusive"), ("valid", "remarks", "invalid")


def many_runs(home: Home) -> None:
    """Runs of 200 units on 6 stations over three years; every tenth without a certificate."""
    rng = np.random.default_rng(16)
    rows: dict[str, list[dict[str, Any]]] = {
        name: [] for name in ("runs", "results", "outcomes", "certificates")
    }
    for number in range(RUNS):
        digest = hashlib.sha256(f"run {number}".encode()).hexdigest()
        run, result, at = f"r{digest[:12]}", f"c{digest[:12]}", FIRST + number * EVERY
        unit, day = number % UNITS + 1, at.date()
        rows["runs"].append({
            "id": run, "digest": digest, "recording_id": f"run {number}", "unit": unit,
            "standard": "JJF 2003-2022", "taken_in_at": at, "seconds": 2400.0, "rows": 240_000,
            "station": f"T{number % STATIONS + 1}", "procedure": "jjf2003", "recorded_on": day,
        })  # fmt: skip
        rows["results"].append({
            "id": result, "run": run, "method": "jjf2003", "code_version": "1", "made_at": at,
            "document": DOCUMENT,
        })  # fmt: skip
        rows["outcomes"].append({
            "result": result, "run": run, "method": "jjf2003", "made_at": at,
            "verdict": str(rng.choice(VALIDITY, p=(0.9, 0.06, 0.04))), "missing": 0,
        })  # fmt: skip
        if number % 10:
            rows["certificates"].append({
                "number": f"MIMU-{number:05d}", "result": result, "run": run, "unit": unit,
                "state": "issued", "verdict": str(rng.choice(VERDICTS, p=(0.9, 0.06, 0.04))),
                "calibrated_on": day, "issued_on": day, "due": day + timedelta(days=365),
                "kept_at": at, "pdf": "", "pdf_sha256": "", "record": "", "record_sha256": "",
            })  # fmt: skip
    units = [
        {"manufacturer": "Maker", "model": f"M{unit % 4}", "serial": f"V{unit:05d}"}
        for unit in range(UNITS)
    ]
    with database.changing(home) as connection:
        connection.execute(sql.insert(tables.units), units)
        for name, made in rows.items():
            connection.execute(sql.insert(tables.metadata.tables[name]), made)
