"""Whether the pages say what a line's store holds: plain SQL and numpy a second time.

Numbers of Line, Runs, Unit, Due and Mismatch, and the station that is tilted.
"""

import json
import os
import sqlite3
import time
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np
from scipy import stats

from flows.terminal import counting, stdout
from schemas.base import Unusable
from schemas.orders import ExplainOrder, ReviewOrder
from storage.catalogue.runs import find
from storage.home import Home
from tasks.stages.explain import explain_run
from tasks.stages.review import review_runs
from tests.pages_server import served
from tests.proof.line import (
    Line,
    Recorded,
    draw_line,
    fill,
    measured_by_grade,
    recorded_runs,
    station_name,
)
from tests.proof.study import Count, Out, Seed, Write, folder_of, publish

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
    for carried in shown["review"]["findings"] if shown["review"] else []:
        for part in (carried, *carried["uncertain"]):
            where = ["1"] + [WHERE[field] for field in part["query"]]
            values = tuple(part["query"].values())
            yield from _papers(database, str(part["query"]), part["papers"], " and ".join(where),
                               *values)  # fmt: skip
        yield from _moved(database, carried)


WHERE = {"station": "r.station = ?", "model": "u.model = ?", "serial": "u.serial = ?",
         "since": "r.recorded_on >= ?", "until": "r.recorded_on <= ?"}  # fmt: skip


def _papers(
    database: sqlite3.Connection, name: str, declared: dict[str, Any], where: str, *values: Any
) -> Iterator[Pair]:
    asked = f"""select c.state, count(*) as papers from certificates c join runs r on r.id = c.run
        join units u on u.id = r.unit where {where} group by c.state"""
    own = {row["state"]: row["papers"] for row in database.execute(asked, values)}
    yield f"{name} issued", declared["issued"], own.get("issued", 0)
    yield f"{name} drafts", declared["drafts"], own.get("draft", 0) + own.get("checked", 0)


def _moved(database: sqlite3.Connection, carried: dict[str, Any]) -> Iterator[Pair]:
    """By how many U: as the review has it, on certificates that the catalogue has of that run."""
    own: dict[str, list[float]] = {}
    for each in carried["finding"]["touched"]:
        own.setdefault(each["certificate"], []).append(each["in_U"])
    yield "moved certificates", len(carried["moved"]), len(own)
    for paper in carried["moved"]:
        asked = "select run, coalesce(draft, number) as draft from certificates where number = ?"
        row = database.execute(asked, (paper["number"],)).fetchone()
        yield f"{paper['number']} run", paper["run"], row["run"]
        in_U = sorted(own.get(paper["number"]) or own.get(row["draft"]) or [])
        yield f"{paper['number']} moved", json.dumps(sorted(m["in_U"] for m in paper["moved"])), (
            json.dumps(in_U))  # fmt: skip


# Whether the pages say what the store holds: asked over HTTP, held against SQL and the answer.

TILTED = ("accel_rate_sensitivity", "xy")
OFF_IN_U = 2.0  # U (k = 2) of a station's difference, from which it counts as off
SEEN_IN_U = 3.0  # U of what the tilt makes of it: then 98 of 100 comparisons find the station off
WITHIN_U = 2.0  # U of the size found: how far it may be off


@dataclass(frozen=True)
class Judged:
    """declared: the cells of the page of evidence by name. faults: what is not as it should be."""

    declared: dict[str, Any]
    faults: tuple[str, ...]


def judge(home: Home, answer: dict[str, Any]) -> Judged:
    """Asks the pages of a home, and holds what they answer against the truth."""
    database = sqlite3.connect(home.path / "catalog.sqlite")
    with served(home) as address:
        mismatch = _get(address, "mismatch", {})
        tilted = _get(address, "quality", dict(zip(("item", "element"), TILTED, strict=True)))
        compared = list(pairs(database, partial(_get, address)))
    wrong = [
        f"{what}: {declared} and not {own}"
        for what, declared, own in compared
        if not same(declared, own)
    ]
    carried, faults = _carried(mismatch, answer, database)
    off = [each["station"] for each in tilted["stations"]
           if each["U"] and abs(each["difference"]) > OFF_IN_U * each["U"]]  # fmt: skip
    power = _power(tilted["stations"], answer, database)
    named, elsewhere, false = _single(mismatch, answer)
    if off != [answer["station"]] and (off or power > SEEN_IN_U):
        faults.append(f"the stations that are off are {off}")
    declared = {
        "same": len(compared) - len(wrong), "numbers": len(compared), "truth": answer["station"],
        "since_truth": answer["since"][:10], "off": ", ".join(off) or "none",
        "power": f"{power:.1f}",
        "size_truth": f"{1e6 * answer['east_rad']:.0f}, {1e6 * answer['north_rad']:.0f}",
        "named": named, "others": elsewhere, **carried,
    }  # fmt: skip
    return Judged(declared, (*wrong[:5], *faults, *false))


def _power(
    stations: list[dict[str, Any]], answer: dict[str, Any], database: sqlite3.Connection
) -> float:
    """What the tilt makes of the tilted station's mean, over the U of its difference."""
    asked = "select avg(recorded_on >= ?) from runs where station = ?"
    ((share,),) = database.execute(asked, (answer["since"][:10], answer["station"]))
    (own,) = (each for each in stations if each["station"] == answer["station"])
    return float(abs(answer["shift"]) * share / own["U"]) if own["U"] else 0.0


def same(declared: Any, own: Any) -> bool:
    """Numbers to the last digits of a double, all else as it is."""
    if isinstance(declared, int | float) and isinstance(own, int | float):
        return bool(np.isclose(declared, own, rtol=1e-9, atol=1e-15))
    return bool(declared == own)


def _get(address: str, page: str, asked: dict[str, str]) -> dict[str, Any]:
    with urllib.request.urlopen(f"{address}/api/v1/{page}?{urlencode(asked)}") as answered:
        found: dict[str, Any] = json.loads(answered.read())
    return found


def _carried(
    shown: dict[str, Any], answer: dict[str, Any], database: sqlite3.Connection
) -> tuple[dict[str, Any], list[str]]:
    """What the review says, in cells, and where that is not the truth."""
    findings = shown["review"]["findings"] if shown["review"] else []
    declared = [f"{each['finding']['level']} {each['finding']['carrier']}" for each in findings]
    cells = {"found": ", ".join(declared) or "nothing", "since": "–", "size": "–"}
    if declared != [f"station {answer['station']}"]:
        return cells, [f"the review finds {declared} and not the tilted station alone"]
    (carried,) = findings
    finding, faults = carried["finding"], []
    if answer["effect"] != finding["effect"]:
        faults.append(f"the review names {finding['effect']}")
    since = finding["since"]["at"] if finding["since"] else ""
    without = finding["since"]["without"] if finding["since"] else ""
    open_ = sum(each["papers"]["issued"] for each in carried["uncertain"])
    cells["since"] = (
        f"between {without[:10]} and {since[:10]}; {carried['papers']['issued']} issued "
        f"certificates since then, {open_} between"
    )
    if not without <= answer["since"] <= since:
        faults.append(f"it is said to begin between {without} and {since}")
    if not _begins(since, answer, database):
        faults.append(
            f"it is said to begin at {since}, not at the first run after {answer['since']}"
        )
    sizes = {each["name"]: each for each in finding["parameters"]}
    cells["size"] = ", ".join(f"{_microrad(sizes[n]):.0f}" for n in ("east", "north"))
    for name in ("east", "north"):
        own = sizes[name]
        off = _microrad(own) - 1e6 * answer[f"{name}_rad"]
        if abs(off) > WITHIN_U * 2.0 * _microrad(own | {"value": own["u"]}):
            faults.append(f"{name} is off by {off:.1f} µrad")
    return cells, faults


def _begins(since: str, answer: dict[str, Any], database: sqlite3.Connection) -> bool:
    """Whether it is the first reviewed run of the station after the tilt."""
    if not since:
        return False
    begins, truth = datetime.fromisoformat(since), datetime.fromisoformat(answer["since"])
    return begins >= truth and begins.date() in _days_of_runs(answer["station"], database)


def _days_of_runs(station: str, database: sqlite3.Connection) -> set[Any]:
    asked = "select recorded_on from runs where station = ?"
    return {datetime.fromisoformat(day).date() for (day,) in database.execute(asked, (station,))}


def _microrad(parameter: dict[str, Any]) -> float:
    factor = {"°": np.pi / 180.0, "deg": np.pi / 180.0, "rad": 1.0, "mrad": 1e-3, "µrad": 1e-6}
    return float(parameter["value"]) * factor[parameter["unit"]] * 1e6


def _single(shown: dict[str, Any], answer: dict[str, Any]) -> tuple[str, str, list[str]]:
    """What single runs are said to show: on the tilted station since then, and elsewhere."""
    since = answer["since"][:10]
    here = [run for run in shown["newest"]
            if run["station"] == answer["station"] and run["day"] > since]  # fmt: skip
    elsewhere = [run for run in shown["newest"] if run not in here]
    names = [[f["effect"] for f in run["findings"]] for run in here]
    right = sum(answer["effect"] in each for each in names)
    false = [f["effect"] for run in elsewhere for f in run["findings"]]
    tilts = [f"{answer['effect']} elsewhere"] if answer["effect"] in false else []
    return f"{right} of {len(here)}", ", ".join(sorted(set(false))) or "none", tilts


LINE_UNITS, RECORDED, EXPLAINED = 200, 48, 12
RUNS_OF_A_UNIT = 5  # at least, of a small line
TEXT = """# A line with years behind it

`make prove ARGS="line {runs} --seed {seed}"`: {runs:,} runs of {units} units of 4 models on 6
stations over three years, made in {made:.0f} s. Each unit has true coefficients that drift, and
some are adjusted; each run measures them with noise of its stated U; some runs are invalid, fail,
lack an item, are retests. One station is tilted from a day on: which one, and when, lies in a file
outside of the store until the pages have answered. {recorded} of the runs have recordings of the
independent plant; `mimucal review` pools these, and `mimucal explain` answers {explained} of them.

| what | answered | held against |
|---|---:|---|
| numbers of Line, Runs, Unit, Due and Mismatch | {same} of {numbers} | SQL, and numpy |
| the tilted station on the Mismatch page | {found} | {truth} |
| since | {since} | {since_truth} |
| size, east and north (µrad) | {size} | {size_truth} |
| stations off by more than 2 U on the Quality page in what a tilt moves | {off} | {truth} |
| names in single runs of the tilted station, since then | {named} | `axis_tilt` |
| names in single runs of the others | {others} | none |

The tilt moves that station's mean by {power} U of the comparison of stations; from 3 U on the
comparison must find it; below that it has too little power for so few runs, and the Mismatch page
alone must.

Faults: {faults}.
"""


def line(count: Count = 10_000, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """The store of a line with N runs, and whether the pages say what it holds.

    Its answer lies sealed beside it. Raises Unusable for a folder in use.
    """
    folder = folder_of("line", out)
    home = Home(folder / "store")
    drawn, made = make_line(seed, count, home)
    judged = judge(home, json.loads(answer_of(home).read_text(encoding="utf-8")))
    publish("line", page_of(drawn, made, judged), folder, write, judged.faults)


def make_line(seed: int, count: int, home: Home) -> tuple[Line, float]:
    """The store of a line that was reviewed, in a new folder, and how long its runs took in s."""
    line = draw_line(seed, count, min(LINE_UNITS, max(1, count // RUNS_OF_A_UNIT)))
    made = make_store(home, line, RECORDED)
    look_back(home)
    return line, made


def look_back(home: Home, explained: int = EXPLAINED) -> None:
    """What the laboratory would do: a review of the recorded runs, and `explain` for the last."""
    recorded = tuple(recorded_runs(home))
    with counting("statistics") as report:
        review_runs(ReviewOrder(paths=recorded), home, report)
    last = recorded[-explained:]
    with counting("explanations") as report:
        for done, run in enumerate(last, start=1):
            explain_run(find(run, home), home, ExplainOrder(run=run))
            report(done, len(last))


def page_of(line: Line, made: float, judged: Judged) -> str:
    """The evidence as Markdown."""
    return TEXT.format(
        runs=line.runs, seed=line.seed, units=len(line.units), made=made, recorded=RECORDED,
        explained=EXPLAINED, faults="; ".join(judged.faults) or "none", **judged.declared,
    )  # fmt: skip


def make_store(home: Home, line: Line, recorded: int) -> float:
    """Seals the answer, makes the store, and gives how long that took in seconds."""
    if home.path.exists() and any(home.path.iterdir()):
        raise Unusable(f"--out {home.path} is not empty; a store needs a folder of its own")
    os.environ["MIMUCAL_HOME"] = str(home.path)
    home.path.mkdir(parents=True, exist_ok=True)
    answer_of(home).write_text(json.dumps(answer(line), indent=1) + "\n", encoding="utf-8")
    began = time.perf_counter()
    with counting("runs of the line") as report:
        fill(home, line, Recorded(recorded), report)
    seconds = time.perf_counter() - began
    stdout(markup=False).print(f"{line.runs} runs in {seconds:.0f} s: {home.path}")
    return seconds


def answer_of(home: Home) -> Path:
    """Where the answer lies: outside of the store."""
    return home.path.with_name(f"{home.path.name}.answer.json")


def answer(line: Line) -> dict[str, object]:
    """What is to be found."""
    tilt, measured = line.tilt, measured_by_grade(line)
    item, element = TILTED
    return {
        "station": station_name(tilt.station), "effect": "axis_tilt",
        "shift": float(np.mean([measured[unit.grade].shift[item][element] for unit in line.units])),
        "since": tilt.since.isoformat(), "east_rad": tilt.east, "north_rad": tilt.north,
    }  # fmt: skip
