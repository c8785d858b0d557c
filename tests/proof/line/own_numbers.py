"""The numbers of the Quality page a second time: plain SQL on the catalogue, and numpy."""

import json
import sqlite3
from collections import Counter
from dataclasses import dataclass
from datetime import date
from typing import Any

import numpy as np

Counts = dict[str, tuple[int, int]]  # passed, of
RUNS = """
with told as (
    select r.id as run, u.model, u.serial, r.station, r.recorded_on as day, r.imported_at as at,
        julianday(r.recorded_on) - lag(julianday(r.recorded_on)) over (
            partition by r.unit order by r.recorded_on, r.imported_at, r.id) as pause,
        (select o.result from outcomes o where o.run = r.id
            order by o.made_at desc limit 1) as result,
        (select c.number from certificates c where c.run = r.id
            order by c.kept_at desc limit 1) as paper
    from runs r join units u on u.id = r.unit
)
select t.run, t.model, t.serial, t.station, t.day, t.pause is null or t.pause > 7 as first,
    o.verdict as validity, o.missing, c.verdict, c.number, e.value, e.expanded
from told t
left join outcomes o on o.result = t.result
left join certificates c on c.number = t.paper
left join elements e on e.result = t.result and e.item = :item and e.element = :element
where t.day >= :since and t.day <= :until
order by t.day, t.at, t.run
"""
BAD = """
select d.item, count(distinct d.certificate), count(distinct case when d.verdict <> 'pass'
    then d.certificate end)
from decisions d where d.certificate in (select value from json_each(:papers)) group by d.item
"""
LIMITS = """
select d.lower, d.upper from decisions d join certificates c on c.number = d.certificate
where c.number in (select value from json_each(:papers)) and d.item = :item
    and d.element = :element order by c.kept_at desc limit 1
"""


@dataclass(frozen=True)
class Own:
    """As QualityShown has them. values: by run, those on the chart."""

    counted: dict[str, int]
    by_station: Counts
    by_model: Counts
    by_week: Counts
    by_item: Counts
    capability: dict[str, float | None]
    indices: dict[str, float | None]
    chart: dict[str, float | None]
    values: dict[str, float]


def own_numbers(database: sqlite3.Connection, shown: dict[str, Any], asked: dict[str, str]) -> Own:
    """What an answer should say. shown: the answer, of which model and element are taken."""
    names = {"item": shown["item"], "element": shown["element"]}
    span = {"since": asked.get("since", "0001-01-01"), "until": asked.get("until", "9999-12-31")}
    database.row_factory = sqlite3.Row
    rows = database.execute(RUNS, names | span).fetchall()
    of_model = [row for row in rows if row["model"] == shown["model"]]
    station = asked.get("station")
    here = [row for row in of_model if station in (None, row["station"])]
    first = [row for row in here if row["first"]]
    decided = list(filter(_is_decided, first))
    everywhere = [
        r for r in rows if r["first"] and _is_decided(r) and station in (None, r["station"])
    ]
    papers = json.dumps([row["number"] for row in decided if row["number"]])
    invalid = [row for row in decided if row["validity"] == "invalid"]
    per_item = database.execute(BAD, {"papers": papers}).fetchall()
    by_item = {item: (of - bad, of + len(invalid)) for item, of, bad in per_item}
    valued = [row for row in here if row["validity"] != "invalid" and row["value"] is not None]
    values = {row["run"]: row["value"] for row in valued}
    able = [row for row in valued if row["first"]]
    limits = database.execute(LIMITS, names | {
        "papers": json.dumps([row["number"] for row in able if row["number"]])
    }).fetchone()  # fmt: skip
    return Own(
        counted={
            "runs": len(here), "first": len(first), "retests": len(here) - len(first),
            "undecided": len(first) - len(decided), "invalid": len(invalid),
        },
        by_station=_counts([r for r in of_model if r["first"] and _is_decided(r)], "station"),
        by_model=_counts(everywhere, "model"),
        by_week=_counts(decided, "day", _week),
        by_item=by_item,
        **_statistics(able, valued, (limits["lower"], limits["upper"]) if limits else (None, None)),
        values=values,
    )  # fmt: skip


def _is_decided(row: sqlite3.Row) -> bool:
    return row["verdict"] is not None or row["validity"] == "invalid"


def _has_passed(row: sqlite3.Row) -> bool:
    return bool(row["validity"] in ("valid", "remarks") and not row["missing"]
                and row["verdict"] == "pass")  # fmt: skip


def _week(day: str) -> str:
    year, week, _ = date.fromisoformat(day).isocalendar()
    return f"{year}-W{week:02d}"


def _counts(rows: list[sqlite3.Row], by: str, named: Any = str) -> Counts:
    of = Counter(named(row[by]) for row in rows)
    passed = Counter(named(row[by]) for row in rows if _has_passed(row))
    return {name: (passed[name], count) for name, count in of.items()}


def _statistics(
    able: list[sqlite3.Row], charted: list[sqlite3.Row],
    limits: tuple[float | None, float | None],
) -> dict[str, Any]:  # fmt: skip
    """Capability of first runs and the chart of all, by the definitions."""
    x, (lower, upper) = np.array([row["value"] for row in able]), limits
    mean, overall = x.mean(), x.std(ddof=1)
    within = np.mean(np.abs(x[1:] - x[:-1])) * np.sqrt(np.pi) / 2.0
    two = None if lower is None or upper is None else upper - lower
    sides = _known(None if upper is None else upper - mean, None if lower is None else mean - lower)
    y = np.array([row["value"] for row in charted])
    ranges = np.abs(y[1:] - y[:-1])
    sigma = ranges.mean() * np.sqrt(np.pi) / 2.0
    share = sorted(_consumed(row, lower, upper) for row in able)
    return {
        "capability": {
            "n": len(x), "lower": lower, "upper": upper, "mean": mean, "within": within,
            "overall": overall, "over": sum(each > 1.0 for each in share),
            "margin_median": share[int(np.ceil(0.5 * len(share))) - 1],
        },
        "indices": {
            "cp": two and two / 6 / within, "pp": two and two / 6 / overall,
            "cpk": min(sides) / 3 / within, "ppk": min(sides) / 3 / overall,
        },
        "chart": {
            "centre": y.mean(), "sigma": sigma, "lower": y.mean() - 3 * sigma,
            "upper": y.mean() + 3 * sigma, "mean_range": ranges.mean(),
        },
    }  # fmt: skip


def _known(*values: float | None) -> list[float]:
    return [value for value in values if value is not None]


def _consumed(row: sqlite3.Row, lower: float | None, upper: float | None) -> float:
    value = row["value"]
    margin = min(
        _known(None if upper is None else upper - value, None if lower is None else value - lower)
    )
    return float(row["expanded"] / margin) if margin > 0 else float("inf")
