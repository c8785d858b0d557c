"""Capability, control chart and station comparison of one element."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd

from flows.pages.quality.models import (
    CapabilityShown,
    Cause,
    ChartShown,
    Choices,
    Event,
    GoldenPoint,
    GoldenShown,
    Plot,
    QualityQuestion,
    StationShown,
)
from storage.catalogue import line_history
from storage.home import Home
from tasks.quality.capability import capability, consumed
from tasks.quality.charts import Chart, individuals
from tasks.quality.golden import HISTORY, station_check
from tasks.quality.stations import against_each_other

Runs = pd.DataFrame


def of_element(
    runs: Runs, selected: Runs, question: QualityQuestion, named: tuple[str, str, str],
    choices: Choices, home: Home,
) -> dict[str, Any]:  # fmt: skip
    """The fields of QualityShown about an element. runs: all; selected: those asked for; named:
    model, item and element. A run that is invalid, or does not determine it, has no value.
    """
    model = named[0]
    rows = line_history.values(*named, home)
    table = pd.DataFrame.from_records(rows, columns=["run", "value", "U"]).set_index("run")
    measured = runs[(runs["model"] == model) & runs["valid"]].join(table.astype(float), on="run")
    measured = measured[np.isfinite(measured["value"])]
    here = measured[measured["run"].isin(selected["run"])]
    in_time = measured[between(measured, question)]
    charted = here if question.plot == "value" else _changes(measured, here)
    if question.serial is None:  # who asks for a golden unit sees it
        charted = charted[~charted["golden"]]
    return {
        "capability": _capability(here[here["first"] & ~here["golden"]], named, home),
        "chart": _chart(charted, question, home),
        "golden": tuple(_golden(here[here["golden"]])),
        "stations": _stations(in_time, choices),
    }  # fmt: skip


def between(runs: Runs, question: QualityQuestion) -> "pd.Series[bool]":
    """Which runs are of the days that are asked for."""
    since, until = pd.Timestamp(question.since or "1900-01-01"), question.until or "2999-12-31"
    return runs["day"].between(since, pd.Timestamp(until))


def _capability(values: Runs, named: tuple[str, str, str], home: Home) -> CapabilityShown:
    rows = line_history.limits(*named, home)
    table = pd.DataFrame.from_records(rows, columns=["run", "lower", "upper"])
    table = table[table["run"].isin(values["run"])].drop_duplicates("run", keep="last")
    newest = table.iloc[-1] if len(table) else None
    lower, upper = (_number(newest[side]) if newest is not None else None
                    for side in ("lower", "upper"))  # fmt: skip
    found = capability(values["value"].to_numpy(), lower, upper)
    share = consumed(
        values["value"].to_numpy(), values["U"].to_numpy(),
        np.full(len(values), np.nan if lower is None else lower),
        np.full(len(values), np.nan if upper is None else upper),
    )  # fmt: skip
    share = share[~np.isnan(share)]
    return CapabilityShown(
        n=found.n, lower=lower, upper=upper,
        limits_vary=len(table[["lower", "upper"]].drop_duplicates()) > 1,
        mean=found.mean, within=found.within, overall=found.overall, cp=found.cp,
        cpk=found.cpk, pp=found.pp, ppk=found.ppk,
        margin_median=_share(share, 0.5), margin_95=_share(share, 0.95),
        over=int((share > 1.0).sum()),
    )  # fmt: skip


def _number(value: Any) -> float | None:
    return float(value) if value is not None and np.isfinite(value) else None


def _share(shares: np.ndarray, quantile: float) -> float | None:
    """The smallest share that so many of them do not exceed; None where it is infinite."""
    if not len(shares):
        return None
    return _number(np.quantile(shares, quantile, method="inverted_cdf"))


def _golden(values: Runs) -> Iterator[GoldenShown]:
    """Each golden unit on each station, since it was adjusted last."""
    for (station, serial), of in values.groupby(["station", "serial"]):
        adjusted = np.flatnonzero(of["adjusted"])
        since = of.iloc[adjusted[-1] if len(adjusted) else 0 :]
        found = since["value"].to_numpy()
        chart = station_check(found)
        lower, upper = chart.limits if chart else (None, None)
        broken = _rules(chart) if chart else [()] * len(found)
        points = zip(since["run"], since["day"].dt.date, found, broken, strict=True)
        yield GoldenShown(
            station=str(station), serial=str(serial), history=min(HISTORY, len(found)),
            centre=chart.centre if chart else None, lower=lower, upper=upper,
            points=tuple(GoldenPoint(run=run, day=day, value=value, broken=rules)
                         for run, day, value, rules in points),
        )  # fmt: skip


def _rules(chart: Chart) -> list[tuple[int, ...]]:
    """The rules that each value breaks."""
    return [tuple((np.flatnonzero(broken) + 1).tolist()) for broken in chart.broken.T]


def _changes(measured: Runs, here: Runs) -> Runs:
    """Values less that of the unit's run before, but for those after an adjustment."""
    ordered = measured.sort_values("unit", kind="stable")
    change = ordered.groupby("unit")["value"].diff()
    change[ordered["adjusted"]] = np.nan
    changed = here.assign(value=change.reindex(here.index))
    return changed[np.isfinite(changed["value"])]


def _chart(values: Runs, question: QualityQuestion, home: Home) -> ChartShown | None:
    chart = individuals(values["value"].to_numpy())
    if chart is None:
        return None
    rules = _rules(chart)
    lower, upper = chart.limits
    points = zip(values["run"], values["day"].dt.date, values["serial"], values["station"],
                 values["value"], chart.ranges, rules, strict=True)  # fmt: skip
    return ChartShown(
        plotted=question.plot, centre=chart.centre, sigma=chart.sigma, lower=lower, upper=upper,
        mean_range=chart.mean_range, range_limit=chart.range_limit,
        points=tuple(
            Plot(run=run, day=day, serial=serial, station=station or "", value=value,
                 range=_number(step), broken=broken)
            for run, day, serial, station, value, step, broken in points
        ),
        events=tuple(sorted(_events(values, question, home), key=lambda each: each.day)),
    )  # fmt: skip


def _events(values: Runs, question: QualityQuestion, home: Home) -> Iterator[Event]:
    """Units adjusted; of one unit the stations it went to; of one station its standards renewed."""
    yield from _marked(values[values["adjusted"]], "adjusted", "serial")
    if question.serial is not None:
        moved = values[values["station"] != values["station"].shift()].iloc[1:]
        yield from _marked(moved, "station", "station")
    if question.station is not None and len(values):
        first, last = values["day"].min().date(), values["day"].max().date()
        for day, serial in line_history.renewals(question.station, home):
            if first <= day <= last:
                yield Event(day=day, cause="equipment", name=serial)


def _marked(runs: Runs, cause: Cause, named: str) -> Iterator[Event]:
    for day, name in zip(runs["day"].dt.date, runs[named], strict=True):
        yield Event(day=day, cause=cause, name=str(name))


def _stations(values: Runs, choices: Choices) -> tuple[StationShown, ...]:
    station = pd.Categorical(values["station"], categories=list(choices.stations))
    known = values[station.codes >= 0]
    codes = station.codes[station.codes >= 0].astype(int)
    units, _ = pd.factorize(known["unit"])
    found = against_each_other(
        units, codes, known["value"].to_numpy(), known["adjusted"].to_numpy(), len(choices.stations)
    )
    counts = np.bincount(codes, minlength=len(choices.stations))
    return tuple(
        StationShown(station=name, difference=_number(difference), U=_number(U), runs=int(count))
        for name, difference, U, count in zip(
            choices.stations, found.difference, found.U, counts, strict=True
        )
        if count
    )
