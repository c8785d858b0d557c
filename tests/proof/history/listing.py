"""How long ten thousand runs take to be listed from either database."""

import time
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

import sqlalchemy as sql

from storage.catalogue import database, run_index, tables
from storage.home import Home
from tests import postgres
from tests.bench.measure import processor_s_of
from tests.proof.history.cluster import catalogue
from tests.proof.history.watch import MIMUCAL, environment, watched

ROWS = 10_000
TIMES = 9
BEGAN = datetime(2026, 1, 1, tzinfo=UTC)


@dataclass(frozen=True)
class Listed:
    """Seconds of listing: in a process that runs, wall and processor time; and as a command."""

    database: str
    rows: int
    wall_s: float
    processor_s: float
    command_s: float
    command_processor_s: float


def listed() -> list[Listed]:
    """The figures of SQLite and of PostgreSQL."""
    with TemporaryDirectory() as folder:
        found = [_measured("SQLite", Home(Path(folder)), environment(MIMUCAL_HOME=folder))]
    with TemporaryDirectory() as folder, postgres.running() as server:
        url = postgres.empty_database(server)
        variables = environment(MIMUCAL_HOME=folder, MIMUCAL_DATABASE=url)
        with catalogue(url):
            found.append(_measured("PostgreSQL", Home(Path(folder)), variables))
    return found


def _measured(name: str, home: Home, variables: dict[str, str]) -> Listed:
    _fill(home)
    wall, work = [], []
    for _ in range(TIMES):
        began, worked = time.perf_counter(), time.process_time()
        rows = len(run_index.all_runs(home))
        wall.append(time.perf_counter() - began)
        work.append(time.process_time() - worked)
    command = (*MIMUCAL, "runs")
    command_s = watched(command, variables).wall_s
    return Listed(
        name, rows, median(wall), median(work), command_s, processor_s_of(command, variables)
    )


def _fill(home: Home) -> None:
    unit = {"id": 1, "manufacturer": "Maker", "model": "U", "serial": "1"}
    rows = [
        {
            "id": f"r{number:012x}", "digest": f"{number:064x}", "recording_id": f"run {number}",
            "unit": 1, "standard": "JJF 2003-2022",
            "imported_at": BEGAN + timedelta(minutes=number), "seconds": 1440.0, "rows": 150_000,
            "station": "T1",
        }
        for number in range(ROWS)
    ]  # fmt: skip
    with database.changing(home) as connection:
        connection.execute(sql.insert(tables.units).values(**unit))
        connection.execute(sql.insert(tables.runs), rows)
