"""Computes the quality of a selection of runs from the catalogue, by tasks/quality."""

from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from datetime import date, datetime, timedelta
from functools import partial
from typing import Any, Literal

import dash_mantine_components as dmc
import numpy as np
import pandas as pd
from dash import ClientsideFunction, Dash, Input, Output
from dash.development.base_component import Component
from pydantic import Field

from flows.pages.parts import Numbers, Row, choice, control_id, place, rows_of, said, say, view
from schemas.base import Finite, Frozen, Unusable
from schemas.text import Statement
from storage import settings
from storage.catalogue import production_history
from storage.catalogue.certificates import AS_LEFT
from storage.catalogue.database import cached_until_commit
from storage.home import Home
from tasks.conformity.limits import is_of_a_limit
from tasks.quality import (
    HISTORY,
    RETEST_DAYS,
    RULES,
    CapabilityIndex,
    Chart,
    against_each_other,
    capability,
    consumed,
    first_runs,
    individuals,
    pooled,
    shares,
    station_check,
    yields,
)
from tasks.specifications.estimate import item_title, symbol
from tasks.words import kind_of, message, statement

# Statistics over many runs: yield, capability, control chart, station against station.

Plotted = Literal["value", "change"]
Cause = Literal["adjusted", "station", "equipment"]
Name = Field(default=None, max_length=200)


class QualityQuestion(Frozen):
    """Of which runs, and of which element. Null: all of them; of model and element: the first one.

    plot: what the control chart shows, values or their changes since the unit's run before.
    """

    model: str | None = Name
    item: str | None = Name
    element: str | None = Name
    station: str | None = Name
    serial: str | None = Name
    since: date | None = None
    until: date | None = None
    plot: Plotted = "value"


class ItemChoice(Frozen):
    """An item with its elements, as the newest result of the model has them."""

    item: str
    title: Statement
    unit: str
    elements: tuple[str, ...]


class Choices(Frozen):
    """What may be asked for. serials: of the model that is chosen."""

    models: tuple[str, ...]
    items: tuple[ItemChoice, ...]
    stations: tuple[str, ...]
    serials: tuple[str, ...]


class Yield(Frozen):
    """How many of how many first runs passed, with the 95 % interval of their share."""

    name: str
    passed: int
    of: int
    share: Finite
    low: Finite
    high: Finite


class PeriodYield(Yield):
    """The yield of adjacent weeks, from a Monday to a Sunday."""

    since: date
    until: date


class Failing(Frozen):
    """How often the first runs of the selection fail a limit. item null: how many are not passed
    for the reason in the title: invalid, or what keeps a certificate from deciding.

    failed, inconclusive: limits of the element, each on one run. cumulative: the share of all that
    did not pass, up to this one.
    """

    item: str | None
    element: str
    title: Statement
    symbol: str
    failed: int
    inconclusive: int
    cumulative: Finite


class Counted(Frozen):
    """The runs of the selection. golden: of golden units, which count no further. retests: not
    counted in any yield. first: the others; undecided: of these the valid ones without a
    certificate or draft, which are not counted either. passed, failed, inconclusive (or passed, but
    for elements that are missing): the valid ones that are counted.
    """

    runs: int
    golden: int
    retests: int
    first: int
    undecided: int
    invalid: int
    passed: int = 0
    failed: int = 0
    inconclusive: int = 0


class CapabilityShown(Frozen):
    """Of the values of valid first runs. mean, within, overall: in the element's unit.

    lower, upper: the limits of the newest certificate; limits_vary: whether others printed others.
    margin_median, margin_95: share of the margin to the nearer limit that U takes, of half and of
    95 % of the values at most; null where it is infinite. over: values less than U within a limit,
    or outside of it.
    """

    n: int
    lower: Finite | None
    upper: Finite | None
    limits_vary: bool
    mean: Finite | None
    within: Finite | None
    overall: Finite | None
    cp: CapabilityIndex
    cpk: CapabilityIndex
    pp: CapabilityIndex
    ppk: CapabilityIndex
    margin_median: Finite | None
    margin_95: Finite | None
    over: int


class Plot(Frozen):
    """A run on the control chart. broken: the rules of Nelson that it breaks, 1 to 8."""

    run: str
    day: date
    serial: str
    station: str
    value: Finite
    range: Finite | None
    broken: tuple[int, ...] = ()


class Event(Frozen):
    """What may have caused a change: of a unit at a run, or of the station's equipment."""

    day: date
    cause: Cause
    name: str


class ChartShown(Frozen):
    """Individual values and moving ranges in the order of time. lower, upper: three sigma."""

    plotted: Plotted
    centre: Finite
    sigma: Finite
    lower: Finite
    upper: Finite
    mean_range: Finite
    range_limit: Finite
    points: tuple[Plot, ...]
    events: tuple[Event, ...] = ()


class GoldenPoint(Frozen):
    """A run of a golden unit. broken: the rules of Nelson that it breaks, 1 to 8."""

    run: str
    day: date
    value: Finite
    broken: tuple[int, ...] = ()


class GoldenShown(Frozen):
    """What a station read of a golden unit, in the order of time.

    centre, lower, upper: of the first `history` values, three sigma; null where there are too few.
    """

    station: str
    serial: str
    history: int
    centre: Finite | None
    lower: Finite | None
    upper: Finite | None
    points: tuple[GoldenPoint, ...]


class StationShown(Frozen):
    """What a station reads beside the mean of all, by units that were run on several. U: k = 2."""

    station: str
    difference: Finite | None
    U: Finite | None
    runs: int


class QualityShown(Frozen):
    """The quality of a selection. item, element: of capability, chart and stations; null where no
    run has a result. Yields by model are those of all models at the station and in the time.
    by_period: adjacent weeks, so many together that a point says something. failing: the most
    frequent first.
    """

    choices: Choices
    model: str | None
    item: str | None
    element: str | None
    title: Statement | None
    symbol: str
    unit: str
    retest_days: int
    counted: Counted
    total: Yield | None
    by_item: tuple[Yield, ...]
    by_model: tuple[Yield, ...]
    by_station: tuple[Yield, ...]
    by_week: tuple[Yield, ...]
    by_period: tuple[PeriodYield, ...]
    failing: tuple[Failing, ...]
    capability: CapabilityShown | None
    chart: ChartShown | None
    golden: tuple[GoldenShown, ...]
    stations: tuple[StationShown, ...]


# Capability, control chart and station comparison of one element.

Runs = pd.DataFrame


def of_element(
    runs: Runs, selected: Runs, question: QualityQuestion, named: tuple[str, str, str],
    choices: Choices, home: Home,
) -> dict[str, Any]:  # fmt: skip
    """The fields of QualityShown about an element. runs: all; selected: those asked for; named:
    model, item and element. A run that is invalid, or does not determine it, has no value.
    """
    model = named[0]
    rows = production_history.values(*named, home)
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
    }


def between(runs: Runs, question: QualityQuestion) -> "pd.Series[bool]":
    """Which runs are of the days that are asked for."""
    since, until = pd.Timestamp(question.since or "1900-01-01"), question.until or "2999-12-31"
    return runs["day"].between(since, pd.Timestamp(until))


def _capability(values: Runs, named: tuple[str, str, str], home: Home) -> CapabilityShown:
    rows = production_history.limits(*named, home)
    table = pd.DataFrame.from_records(rows, columns=["run", "lower", "upper"])
    table = table[table["run"].isin(values["run"])].drop_duplicates("run", keep="last")
    newest = table.iloc[-1] if len(table) else None
    lower, upper = (
        _number(newest[side]) if newest is not None else None for side in ("lower", "upper")
    )
    found = capability(values["value"].to_numpy(), lower, upper)
    share = consumed(
        values["value"].to_numpy(),
        values["U"].to_numpy(),
        np.full(len(values), np.nan if lower is None else lower),
        np.full(len(values), np.nan if upper is None else upper),
    )
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
        for day, serial in production_history.renewals(question.station, home):
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


Limit = tuple[str | None, str]  # item and element; without an item, the reason
COLUMNS = ("run", "unit", "model", "serial", "station", "recorded_on", "imported_at", "validity",
           "missing", "verdict", "purpose")  # fmt: skip


def data(question: QualityQuestion, home: Home) -> QualityShown:
    """Yields of the selection, and capability, chart, golden units and stations of an element.

    Raises Unusable for a model, item or element that the catalogue does not have.
    """
    return _data(question, settings.quality(home).golden, home)


@cached_until_commit(16)
def _data(question: QualityQuestion, golden: tuple[str, ...], home: Home) -> QualityShown:
    every = runs_of(home)
    runs = every.assign(golden=every["serial"].isin(golden))
    choices = _choices(runs, question, home)
    model = question.model or next(iter(choices.models), None)
    chosen = _element(choices, question)
    asked = _within(runs, question)
    of_model = asked[asked["model"] == model] if model else asked
    if question.serial is not None:
        of_model = of_model[of_model["serial"] == question.serial]
    counted = _decided(of_model)
    weeks = _yields(counted.assign(week=counted["day"].dt.strftime("%G-W%V")), "week")
    item, element = (chosen[0].item, chosen[1]) if chosen else (None, None)
    shown = {}
    if model and item and element:
        shown = of_element(runs, of_model, question, (model, item, element), choices, home)
    return QualityShown(
        choices=choices, model=model, item=item, element=element,
        title=statement(item_title(item)) if item else None,
        symbol=symbol(item, element) if item and element else "",
        unit=chosen[0].unit if chosen else "", retest_days=RETEST_DAYS, counted=_counted(of_model),
        total=next(iter(_yields(counted.assign(all="all"), "all")), None),
        by_item=_by_item(of_model, model, home),
        by_model=_yields(_decided(asked), "model"),
        by_station=_yields(_decided(_of(runs, question, model)), "station"),
        by_week=weeks, by_period=tuple(_periods(weeks)), failing=_failing(counted, model, home),
        **{"capability": None, "chart": None, "golden": (), "stations": (), **shown},
    )  # fmt: skip


@cached_until_commit(2)
def runs_of(home: Home) -> Runs:
    """Every run in the order of time: who, where, on which day, how it ended, and whether it was
    the first of its unit's visit.

    passed: it is valid, no element is missing, and its certificate passes it. adjusted: its unit
    was, since its run before.
    """
    table = pd.DataFrame.from_records(production_history.ended(home), columns=list(COLUMNS))
    day = pd.to_datetime(table["recorded_on"])
    taken = pd.to_datetime(table["imported_at"], utc=True).dt.tz_localize(None).dt.normalize()
    table["day"] = day.fillna(taken)
    table["order"] = np.arange(len(table))
    table = table.sort_values(["day", "order"], kind="stable").reset_index(drop=True)
    table["adjusted"] = table["purpose"].str.contains(AS_LEFT, regex=False).eq(True)
    table["valid"] = table["validity"].isin(["valid", "remarks"])
    table["passed"] = table["valid"] & (table["missing"] == 0) & (table["verdict"] == "pass")
    table["first"] = first_runs(table)
    return table


def _within(runs: Runs, question: QualityQuestion) -> Runs:
    """The runs at the station and in the time that are asked for."""
    runs = runs[between(runs, question)]
    return runs if question.station is None else runs[runs["station"] == question.station]


def _of(runs: Runs, question: QualityQuestion, model: str | None) -> Runs:
    """The runs of the model in that time at all stations."""
    return runs[between(runs, question) & (runs["model"] == model)]


def _decided(runs: Runs) -> Runs:
    """First runs that count: those with a certificate or draft, and those that are invalid, but
    for golden units.
    """
    has_ended = runs["verdict"].notna() | (runs["validity"] == "invalid")
    return runs[runs["first"] & has_ended & ~runs["golden"]]


def _counted(runs: Runs) -> Counted:
    made = runs[~runs["golden"]]
    first = made[made["first"]]
    valid = first[first["validity"] != "invalid"]
    passed, failed = int(first["passed"].sum()), int((valid["verdict"] == "fail").sum())
    undecided = int(valid["verdict"].isna().sum())
    return Counted(
        runs=len(runs), golden=len(runs) - len(made), retests=len(made) - len(first),
        first=len(first), undecided=undecided, invalid=len(first) - len(valid), passed=passed,
        failed=failed, inconclusive=len(valid) - undecided - passed - failed,
    )  # fmt: skip


def _yields(runs: Runs, by: str) -> tuple[Yield, ...]:
    return _listed(yields(runs, by))


def _listed(table: pd.DataFrame) -> tuple[Yield, ...]:
    return tuple(
        Yield.model_validate({"name": str(name), **row})
        for name, row in table.to_dict("index").items()
    )


def _by_item(runs: Runs, model: str | None, home: Home) -> tuple[Yield, ...]:
    """An item passes a run whose certificate passes all of its limited elements, if it is valid."""
    if model is None:
        return ()
    decided = _decided(runs)
    is_valid = dict(zip(decided["run"], decided["valid"], strict=True))
    passed, of = Counter[str](), Counter[str]()
    certified = set()
    for run, item, not_passed in production_history.decided_items(model, home):
        if run in is_valid:
            certified.add(run)
            of[item] += 1
            passed[item] += is_valid[run] and not not_passed
    invalid = sum(not valid for run, valid in is_valid.items() if run not in certified)
    items = sorted(of, key=place)
    table = shares([passed[item] for item in items], [of[item] + invalid for item in items], items)
    return _listed(table)


def _periods(weeks: Sequence[Yield]) -> Iterator[PeriodYield]:
    """Adjacent weeks put together; between them lie weeks without a run."""
    for part in pooled([each.of for each in weeks]):
        first, *_ = of = weeks[part]
        last = of[-1]
        name = first.name if first is last else f"{first.name} … {last.name}"
        table = shares([sum(each.passed for each in of)], [sum(each.of for each in of)], [name])
        yield PeriodYield(
            since=_monday(first.name),
            until=_monday(last.name) + timedelta(days=6),
            **_listed(table)[0].model_dump(),
        )


def _monday(week: str) -> date:
    return datetime.strptime(f"{week}-1", "%G-W%V-%u").date()


def _failing(decided: Runs, model: str | None, home: Home) -> tuple[Failing, ...]:
    """Limits that certificates of valid runs do not pass, what keeps the others from being decided
    on, and the runs that are invalid.
    """
    if model is None:
        return ()
    valid = decided[decided["valid"]]
    runs = set(valid["run"])
    failed, inconclusive = Counter[Limit](), Counter[Limit]()
    reasons: dict[Hashable, Statement] = {}
    for run, item, element, verdict in production_history.not_passed(model, home):
        if run in runs:
            (failed if verdict == "fail" else inconclusive)[item, element] += 1
    for run, reason in production_history.reasons(model, home):
        if run in runs and not is_of_a_limit(reason):
            kind = reasons.setdefault(kind_of(reason), reason)
            inconclusive[None, kind.en] += 1
    invalid = statement(message("pages-quality-invalid"))
    failed[None, invalid.en] = len(decided) - len(valid)
    titles = {title.en: title for title in (invalid, *reasons.values())}
    both = failed + inconclusive  # without what never happens
    total, up_to, found = both.total(), 0, []
    for (item, element), count in both.most_common():
        up_to += count
        found.append(Failing(
            item=item, element=element if item else "",
            title=statement(item_title(item)) if item else titles[element],
            symbol=symbol(item, element) if item else "", failed=failed[item, element],
            inconclusive=inconclusive[item, element], cumulative=up_to / total,
        ))  # fmt: skip
    return tuple(found)


def _choices(runs: Runs, question: QualityQuestion, home: Home) -> Choices:
    models = sorted(runs["model"].unique())
    model = _known(question.model, models, "model") or next(iter(models), None)
    of_model = runs[runs["model"] == model]
    serials, stations = (
        sorted(of_model["serial"].unique()),
        sorted(runs["station"].dropna().unique()),
    )
    _known(question.serial, serials, f"unit of model {model}")
    _known(question.station, stations, "station")
    return Choices(
        models=tuple(models), items=_items(model, home) if model else (), stations=tuple(stations),
        serials=tuple(serials),
    )  # fmt: skip


def _items(model: str, home: Home) -> tuple[ItemChoice, ...]:
    found: dict[str, list[str]] = {}
    units: dict[str, str] = {}
    for item, element, unit in production_history.items(model, home):
        found.setdefault(item, []).append(element)
        units[item] = unit
    return tuple(
        ItemChoice(item=item, title=statement(item_title(item)), unit=units[item],
                   elements=tuple(sorted(found[item], key=partial(place, item))))
        for item in sorted(found, key=place)
    )  # fmt: skip


def _element(choices: Choices, question: QualityQuestion) -> tuple[ItemChoice, str] | None:
    """The item and its element that are asked for, else the first; None without any result."""
    _known(question.item, [each.item for each in choices.items], "item")
    item = next((i for i in choices.items if question.item in (None, i.item)), None)
    if item is None:
        return None
    element = _known(question.element, item.elements, f"element of {item.item}")
    return item, element or item.elements[0]


def _known(asked: str | None, known: Sequence[str], what: str) -> str | None:
    if asked is not None and asked not in known:
        listed = ", ".join(known[:12]) + (", …" if len(known) > 12 else "")
        raise Unusable(
            f"there is no {what} {asked!r}; there are {listed or 'none'}",
            message("cause-none.choice", name=asked, known=listed or "–"),
        )
    return asked


# What the Quality page is asked for, as controls, and what they do.

EVERY = "pages-quality-all"


def choices(shown: QualityShown, question: QualityQuestion) -> Component:
    """The question as it was answered, in controls that ask another one."""
    asked = question.model_dump(mode="json") | {
        "model": shown.model, "item": shown.item, "element": shown.element
    }  # fmt: skip
    known = shown.choices
    item = next((each for each in known.items if each.item == shown.item), None)
    of_items = [{"value": i.item, "label": say(i.title)} for i in known.items]
    of_elements = (
        [{"value": e, "label": symbol(item.item, e)} for e in item.elements] if item else []
    )
    plots = [
        {"value": each, "label": said(f"pages-quality-plot.{each}")} for each in ("value", "change")
    ]

    def select(name: str, values: Sequence[Any], every: str = "") -> Component:
        return choice(name, f"pages-quality-asked.{name}", values, asked[name], every)

    def day(name: str) -> Component:
        return dmc.DateInput(
            id=control_id(name, asked[name]), label=said(f"pages-quality-asked.{name}"),
            value=asked[name], valueFormat="YYYY-MM-DD", clearable=True, placeholder="YYYY-MM-DD",
        )  # fmt: skip

    controls = [
        select("model", known.models), select("item", of_items), select("element", of_elements),
        select("station", known.stations, EVERY), select("serial", known.serials, EVERY),
        day("since"), day("until"), select("plot", plots),
    ]  # fmt: skip
    shown_all = dmc.SimpleGrid(controls, cols={"base": 2, "sm": 4}, spacing="xs")
    return dmc.DatesProvider(shown_all, settings={"locale": view().language, "firstDayOfWeek": 1})


def callbacks(app: Dash, _: Home) -> None:
    """A point of the chart is its run."""
    app.clientside_callback(
        ClientsideFunction("quality", "open"),
        Output("address", "href"),
        Input("quality-chart", "clickData"),
        prevent_initial_call=True,
    )


# The numbers of each table and chart of the Quality page, as rows.


def _of_element(shown: QualityShown) -> dict[str, Any]:
    return {"model": shown.model, "item": shown.item, "element": shown.element, "unit": shown.unit}


def _total(shown: QualityShown) -> Sequence[Row]:
    return rows_of([each for each in (shown.total, *shown.by_item) if each], model=shown.model)


def _capability_rows(shown: QualityShown) -> Sequence[Row]:
    found = [shown.capability] if shown.capability else []
    return rows_of(found, **_of_element(shown))


def _chart_rows(shown: QualityShown) -> Sequence[Row]:
    if shown.chart is None:
        return []
    limits = {name: getattr(shown.chart, name)
              for name in ("plotted", "centre", "lower", "upper", "range_limit")}  # fmt: skip
    return rows_of(shown.chart.points, **_of_element(shown), **limits)


def _rule_rows(shown: QualityShown) -> Sequence[Row]:
    points = shown.chart.points if shown.chart else ()
    return [
        {**_of_element(shown), "rule": rule, "count": sum(rule in each.broken for each in points)}
        for rule in range(1, RULES + 1)
    ]


def _golden_rows(shown: QualityShown) -> Sequence[Row]:
    return [
        row
        for of in shown.golden
        for row in rows_of(
            of.points, **_of_element(shown), **of.model_dump(mode="json", exclude={"points"})
        )
    ]


NUMBERS: Numbers = {
    "by_period": lambda shown: rows_of(shown.by_period, model=shown.model),
    "by_item": _total,
    "by_station": lambda shown: rows_of(shown.by_station, model=shown.model),
    "by_model": lambda shown: rows_of(shown.by_model),
    "failing": lambda shown: rows_of(shown.failing, model=shown.model),
    "capability": _capability_rows,
    "chart": _chart_rows,
    "rules": _rule_rows,
    "golden": _golden_rows,
    "stations": lambda shown: rows_of(shown.stations, **_of_element(shown)),
}
