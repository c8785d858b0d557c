"""Whether the pages say what the store holds: asked over HTTP, held against SQL and the answer."""

import json
import sqlite3
import urllib.request
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from typing import Any
from urllib.parse import urlencode

import numpy as np

from storage.home import Home
from tests.pages_server import served
from tests.proof.line import own_pages
from tests.proof.line.own_numbers import Own, own_numbers

TILTED = ("accel_rate_sensitivity", "xy")
OFF_IN_U = 2.0  # U (k = 2) of a station's difference, from which it counts as off
SEEN_IN_U = 3.0  # U of what the tilt makes of it: then 98 of 100 comparisons find the station off
WITHIN_U = 2.0  # U of the size found: how far it may be off
ASKED: tuple[dict[str, str], ...] = (
    {}, {"model": "MX-400"}, {"model": "MX-210", "station": "ST-02"},
    {"model": "MX-120", "item": "accel_bias", "element": "z", "until": "2025-03-31"},
    {"model": "MX-110", "item": "gyro_g_sensitivity", "element": "zx", "since": "2025-01-01"},
    {"model": "MX-400", "item": "gyro_scale_factor", "element": "y", "station": "ST-05",
     "since": "2024-06-01", "until": "2026-06-01"},
)  # fmt: skip


@dataclass(frozen=True)
class Judged:
    """declared: the cells of the page of evidence by name. faults: what is not as it should be."""

    declared: dict[str, Any]
    faults: tuple[str, ...]


def judge(home: Home, answer: dict[str, Any]) -> Judged:
    """Asks the pages of a home, and holds what they answer against the truth."""
    database = sqlite3.connect(home.path / "catalog.sqlite")
    with served(home) as address:
        quality = [(asked, _get(address, "quality", asked)) for asked in ASKED]
        mismatch = _get(address, "mismatch", {})
        tilted = _get(address, "quality", dict(zip(("item", "element"), TILTED, strict=True)))
        others = list(own_pages.pairs(database, partial(_get, address)))
    compared = [
        (f"{asked} {name}", declared, own)
        for asked, shown in quality
        for name, declared, own in _pairs(shown, own_numbers(database, shown, asked))
    ]
    wrong, wrong_elsewhere = (
        [
            f"{what}: {declared} and not {own}"
            for what, declared, own in each
            if not same(declared, own)
        ]
        for each in (compared, others)
    )
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
        "same_others": len(others) - len(wrong_elsewhere), "numbers_others": len(others),
    }  # fmt: skip
    return Judged(declared, (*wrong[:5], *wrong_elsewhere[:5], *faults, *false))


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


def _pairs(shown: dict[str, Any], own: Own) -> list[tuple[str, float | None, float | None]]:
    """Each number that the page shows beside the same one counted again."""
    found: list[tuple[str, float | None, float | None]] = []
    found += [(name, shown["counted"][name], own.counted[name]) for name in own.counted]
    for part in ("by_station", "by_model", "by_week", "by_item"):
        yields = {each["name"]: each for each in shown[part]}
        counted = getattr(own, part)
        found.append((f"{part} groups", len(yields), len(counted)))
        for name, (passed, of) in counted.items():
            declared = yields.get(name, {})
            found += [(f"{part} {name} passed", declared.get("passed"), passed),
                      (f"{part} {name} of", declared.get("of"), of)]  # fmt: skip
    chart, ability = shown["chart"], shown["capability"]
    found += [(name, ability[name], value) for name, value in own.capability.items()]
    found += [(name, ability[name]["value"], value) for name, value in own.indices.items()]
    found += [(name, chart[name], value) for name, value in own.chart.items()]
    declared = {point["run"]: point["value"] for point in chart["points"]}
    found.append(("points", len(declared), len(own.values)))
    found += [(f"value of {run}", declared.get(run), value) for run, value in own.values.items()]
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
    return begins >= truth and begins.date() in _days(answer["station"], database)


def _days(station: str, database: sqlite3.Connection) -> set[Any]:
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
