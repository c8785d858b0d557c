"""Whether the pages say what a line's store holds: plain SQL and numpy a second time."""

import json
import sqlite3
import time
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import date, timedelta
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import urlencode

import numpy as np
from scipy import stats

from flows.terminal import counting
from storage.home import Home
from tests.pages_server import served
from tests.proof.line import LINE_UNITS, Recorded, draw_line, fill
from tests.proof.study import Count, Out, Seed, Write, hold

Asking = Callable[[str, dict[str, str]], dict[str, Any]]  # page and question
Pair = tuple[str, Any, Any]  # what, as the page says, as counted here
UNITS = (1, 7, 42, 133, 200)
WITHIN = 180  # days
LISTS: tuple[tuple[dict[str, str], str], ...] = (
    ({}, "1"),
    ({"station": "ST-03"}, "station = 'ST-03'"),
    ({"validity": "invalid"}, "validity = 'invalid'"),
    ({"verdict": "fail", "model": "MX-210"}, "verdict = 'fail' and model = 'MX-210'"),
    ({"result_state": "partial"}, "missing > 0"),
    ({"since": "2024-06-01", "until": "2024-06-30"}, "day between '2024-06-01' and '2024-06-30'"),
    ({"serial": "SN0042", "state": "issued"}, "serial = 'SN0042' and state = 'issued'"),
)
LISTED = """
with last as (
    select r.*, r.recorded_on as day, u.model, u.serial,
        (select o.result from outcomes o where o.run = r.id order by o.made_at desc limit 1) made,
        (select c.number from certificates c where c.run = r.id
            order by c.kept_at desc limit 1) paper
    from runs r join units u on u.id = r.unit
)
select l.id, l.model, l.serial, l.station, l.day, l.seconds, o.missing, o.verdict as validity,
    c.number, c.state, c.verdict, c.due, c.purpose, l.made, l.unit, l.imported_at
from last l left join outcomes o on o.result = l.made left join certificates c on c.number = l.paper
"""
SAME = ("model", "serial", "station", "seconds", "missing", "validity", "state", "verdict", "due")
COLUMNS = {name: name for name in SAME} | {"recorded_on": "day", "certificate": "number"}
NEWEST = """
select * from (select c.*, row_number() over (partition by unit order by
    coalesce(calibrated_on, issued_on) desc, issued_on desc, kept_at desc) as place
    from certificates c where state = 'issued') where place = 1
"""


def pairs(database: sqlite3.Connection, ask: Asking) -> Iterator[Pair]:
    """Each number that the pages show beside the same one from the catalogue's tables."""
    database.row_factory = sqlite3.Row
    yield from _line(database, ask("line", {}))
    for asked, where in LISTS:
        yield from _runs(database, f"runs {asked}", ask("runs", asked | {"count": "200"}), where)
    yield from _unit_list(database, ask("unit", {}))
    for unit in UNITS:
        if _one(database, "select count(*) from units where id = ?", unit):
            yield from _unit(database, ask("unit", {"id": str(unit)}))
    yield from _due(database, ask("due", {"within": str(WITHIN)}))
    yield from _mismatch(database, ask("mismatch", {}))


def _one(database: sqlite3.Connection, sql: str, *values: Any) -> Any:
    return database.execute(sql, values).fetchone()[0]


def _line(database: sqlite3.Connection, shown: dict[str, Any]) -> Iterator[Pair]:
    today = shown["today"]
    rows = database.execute(f"{LISTED} where date(l.imported_at) = ?", (today["day"],)).fetchall()
    yield "line runs", today["runs"], len(rows)
    for name in ("valid", "remarks", "invalid"):
        yield f"line {name}", today[name], sum(row["validity"] == name for row in rows)
    yield "line not judged", today["not_judged"], sum(row["made"] is None for row in rows)
    for name, verdict in (("passed", "pass"), ("failed", "fail")):
        yield f"line {name}", today[name], sum(row["verdict"] == verdict for row in rows)
    stations = {row["station"] for row in rows}
    yield "line stations", sorted(today["by_station"]), sorted(each or "" for each in stations)
    issued = """select count(*) from certificates
        where issued_on = ? and state in ('issued', 'amended', 'withdrawn')"""
    yield "line issued", today["issued"], _one(database, issued, today["day"])


def _runs(
    database: sqlite3.Connection, name: str, shown: dict[str, Any], where: str
) -> Iterator[Pair]:
    rows = {row["id"]: row for row in database.execute(f"select * from ({LISTED}) where {where}")}
    yield name, shown["total"], len(rows)
    yield f"{name} rows", len(shown["runs"]), min(200, len(rows))
    for run in shown["runs"]:
        own = rows.get(run["id"])
        for column, source in COLUMNS.items():
            yield f"{name} {run['id']} {column}", run[column], own and own[source]


def _unit_list(database: sqlite3.Connection, shown: dict[str, Any]) -> Iterator[Pair]:
    yield "units", shown["total"], _one(database, "select count(*) from units")
    papers = {row["unit"]: row for row in database.execute(NEWEST)}
    counts = "select unit, count(*) as runs, max(recorded_on) as last_run from runs group by unit"
    counted = {row["unit"]: row for row in database.execute(counts)}
    for unit in shown["units"]:
        paper, own = papers.get(unit["id"]), counted[unit["id"]]
        yield f"unit {unit['id']} runs", unit["runs"], own["runs"]
        yield f"unit {unit['id']} last", unit["last_run"], own["last_run"]
        for column, source in (("certificate", "number"), ("verdict", "verdict"), ("due", "due")):
            yield f"unit {unit['id']} {column}", unit[column], paper and paper[source]


def _unit(database: sqlite3.Connection, shown: dict[str, Any]) -> Iterator[Pair]:
    number = shown["unit"]["id"]
    runs = database.execute(
        f"select * from ({LISTED}) where unit = ? order by day, imported_at, id", (number,)
    ).fetchall()
    issued = "select number from certificates where unit = ? order by number"
    own = [row["number"] for row in database.execute(issued, (number,))]
    yield f"unit {number} papers", sorted(each["number"] for each in shown["certificates"]), own
    for of in shown["elements"]:
        name = f"unit {number} {of['item']} {of['element']}"
        key = (of["item"], of["element"])
        found = {}
        for run in runs:
            asked = "select * from elements where result = ? and item = ? and element = ?"
            found[run["id"]] = database.execute(asked, (run["made"], *key)).fetchone()
        known = {run: row for run, row in found.items() if row is not None}
        yield f"{name} readings", len(of["readings"]), len(known)
        for reading in of["readings"]:
            row = known.get(reading["run"])
            yield f"{name} {reading['run']}", reading["value"], row and row["value"]
            yield f"{name} U of {reading['run']}", reading["U"], row and row["expanded"]
        limits = """select lower, upper from decisions where certificate = ? and item = ?
            and element = ? and applied_to = 'value'"""
        edges = database.execute(limits, (shown["limits_of"], *key)).fetchone()
        yield f"{name} lower", of["lower"], edges and edges["lower"]
        yield f"{name} upper", of["upper"], edges and edges["upper"]
        per_year, U = _drift(runs, known)
        yield f"{name} drift", of["drift"] and of["drift"]["per_year"], per_year
        yield f"{name} U of drift", of["drift"] and of["drift"]["U"], U


def _drift(
    runs: list[sqlite3.Row], known: dict[str, sqlite3.Row]
) -> tuple[float | None, float | None]:
    """Slope and U by lstsq with a level for each adjustment."""
    level, rows = 0, []
    for run in runs:
        one = known.get(run["id"])
        if one is None or run["validity"] == "invalid":
            continue
        level += "as-left" in (run["purpose"] or "").split()
        if one["value"] is not None and one["u"]:
            years = date.fromisoformat(run["day"]).toordinal() / 365.25
            rows.append((level, years, one["value"], one["u"]))
    if len(rows) < 2:
        return None, None
    levels, times, values, u = (np.array(column) for column in zip(*rows, strict=True))
    names = np.unique(levels)
    columns = [levels == name for name in names] + [times - times.mean()]
    design = np.column_stack(columns) / u[:, None]
    if np.linalg.matrix_rank(design) < design.shape[1]:
        return None, None
    solution, *_ = np.linalg.lstsq(design, values / u, rcond=None)
    spread = np.sqrt(np.linalg.inv(design.T @ design)[-1, -1])
    freedom = len(values) - len(names) - 1
    scattered = 0.0
    if freedom > 0:
        chi2 = np.sum((values / u - design @ solution) ** 2) / freedom
        scattered = stats.t.ppf(0.97725, freedom) * np.sqrt(chi2) * spread
    return float(solution[-1]), float(max(2.0 * spread, scattered))


def _due(database: sqlite3.Connection, shown: dict[str, Any]) -> Iterator[Pair]:
    today = date.fromisoformat(shown["today"])
    until = str(today + timedelta(days=WITHIN))
    due = {row["unit"]: row["due"] for row in database.execute(NEWEST) if row["due"]}
    own = {unit: day for unit, day in due.items() if day <= until}
    yield "due units", len(shown["units"]), len(own)
    for unit in shown["units"]:
        day = own.get(unit["unit"])
        yield f"due {unit['unit']}", unit["due"], day
        yield f"due {unit['unit']} days", unit["days"], day and _days(day, today)
    overdue = sum(day < str(today) for day in own.values())
    yield "overdue of clients", sum(each["overdue"] for each in shown["by_client"]), overdue
    coming = sum(each["coming"] for each in shown["by_client"])
    yield "coming of clients", coming, len(own) - overdue
    for month in shown["months"]:
        of = [day for day in due.values() if day >= str(today) and day[:7] == month["month"]]
        yield f"due in {month['month']}", month["units"], len(of)
    yield "messages", len(shown["messages"]), _one(database, "select count(*) from reminders")
    serials = "select count(distinct serial) from standards"
    yield "equipment", len(shown["equipment"]), _one(database, serials)


def _days(day: str, today: date) -> int:
    return (date.fromisoformat(day) - today).days


def _mismatch(database: sqlite3.Connection, shown: dict[str, Any]) -> Iterator[Pair]:
    yield "mismatch runs", shown["runs"], _one(database, "select count(*) from runs")
    yield "explained", shown["explained"], _one(database, "select count(*) from explained")
    for effect in shown["effects"]:
        name, of = effect["effect"], "select run from findings where effect = ?"
        yield f"{name} runs", effect["runs"], _one(
            database, f"select count(distinct run) from ({of})", name
        )  # fmt: skip
        yield from _papers(database, name, effect["papers"], f"r.id in ({of})", name)
        for part, column in (("station", "r.station"), ("model", "u.model"), ("unit", "u.serial")):
            for each in effect[f"by_{part}"]:
                asked = f"""select count(*) from runs r join units u on u.id = r.unit
                    join explained x on x.run = r.id where {column} = ?"""
                yield f"{name} of {each['name']}", each["of"], _one(database, asked, each["name"])
                own = _one(database, f"{asked} and r.id in ({of})", each["name"], name)
                yield f"{name} of {each['name']}", each["shown"], own


def _papers(
    database: sqlite3.Connection, name: str, declared: dict[str, Any], where: str, *values: Any
) -> Iterator[Pair]:
    asked = f"""select c.state, count(*) as papers from certificates c join runs r on r.id = c.run
        join units u on u.id = r.unit where {where} group by c.state"""
    own = {row["state"]: row["papers"] for row in database.execute(asked, values)}
    yield f"{name} issued", declared["issued"], own.get("issued", 0)
    yield f"{name} drafts", declared["drafts"], own.get("draft", 0) + own.get("checked", 0)


def same(declared: Any, own: Any) -> bool:
    """Numbers to the last digits of a double, all else as it is."""
    if isinstance(declared, int | float) and isinstance(own, int | float):
        return bool(np.isclose(declared, own, rtol=1e-9, atol=1e-15))
    return bool(declared == own)


def _get(address: str, page: str, asked: dict[str, str]) -> dict[str, Any]:
    with urllib.request.urlopen(f"{address}/api/v1/{page}?{urlencode(asked)}") as answered:
        found: dict[str, Any] = json.loads(answered.read())
    return found


# The store of a line, the pages asked over HTTP, and what they say otherwise than the catalogue.

RUNS_OF_A_UNIT = 5  # at least, of a small line
RECORDED = 48  # runs with a recording


@dataclass(frozen=True)
class Compared:
    """A store of so many units, made in so many seconds; of so many numbers these are wrong."""

    units: int
    made_s: float
    numbers: int
    wrong: tuple[str, ...]


def line(count: Count = 10_000, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """The store of a line with N runs, and whether the pages say what it holds."""
    hold("line", {f"{seed}-{count}": (seed, count)}, _compared, partial(_page, count, seed), out,
         write=write, at_once=0, faults=lambda one: one.wrong)  # fmt: skip


def _compared(drawn: tuple[int, int]) -> Compared:
    seed, count = drawn
    line = draw_line(seed, count, min(LINE_UNITS, max(1, count // RUNS_OF_A_UNIT)))
    with TemporaryDirectory() as folder, counting("runs of the line") as report:
        home, began_s = Home(Path(folder) / "store"), time.perf_counter()
        fill(home, line, Recorded(RECORDED), report)
        made_s = time.perf_counter() - began_s
        database = sqlite3.connect(home.path / "catalog.sqlite")
        with served(home) as address:
            compared = list(pairs(database, partial(_get, address)))
    wrong = (f"{what}: {shown}, not {own}" for what, shown, own in compared if not same(shown, own))
    return Compared(len(line.units), made_s, len(compared), tuple(wrong))


def _page(count: int, seed: int, found: list[Compared]) -> str:
    (one,) = found
    return f"""# A line with years behind it

`make prove ARGS="line {count} --seed {seed}"`: {count:,} runs of {one.units} units of 4 models on 6
stations over three years, made in {one.made_s:.0f} s. Each unit has true coefficients that drift,
and some are adjusted; each run measures them with noise of its stated U; some runs are invalid,
fail, lack an item, are retests; {RECORDED} have recordings of the independent plant. Of
{one.numbers:,} numbers of Line, Runs, Unit, Due and Mismatch {one.numbers - len(one.wrong):,} are
those of SQL and numpy.
"""
