"""Computes the quality of a selection of runs from the catalogue, by tasks/quality."""

from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from datetime import date, datetime, timedelta
from functools import partial

import numpy as np
import pandas as pd

from flows.pages.quality.element import between, of_element
from flows.pages.quality.models import (
    Choices,
    Counted,
    Failing,
    ItemChoice,
    PeriodYield,
    QualityQuestion,
    QualityShown,
    Yield,
)
from flows.pages.specification_order import place
from schemas.base import Unusable
from schemas.text import Statement
from storage import settings
from storage.catalogue import line_history
from storage.catalogue.certificates import AS_LEFT
from storage.catalogue.unchanged import while_unchanged
from storage.home import Home
from tasks.conformity.reasons import is_of_a_limit
from tasks.quality.yields import RETEST_DAYS, first_runs, pooled, shares, yields
from tasks.specifications.items import item_title, symbol
from tasks.words import kind_of, message, statement

Runs = pd.DataFrame
Limit = tuple[str | None, str]  # item and element; without an item, the reason
COLUMNS = ("run", "unit", "model", "serial", "station", "recorded_on", "imported_at", "validity",
           "missing", "verdict", "purpose")  # fmt: skip


def data(question: QualityQuestion, home: Home) -> QualityShown:
    """Yields of the selection, and capability, chart, golden units and stations of an element.

    Raises Unusable for a model, item or element that the catalogue does not have.
    """
    return _data(question, settings.quality(home).golden, home)


@while_unchanged(16)
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


@while_unchanged(2)
def runs_of(home: Home) -> Runs:
    """Every run in the order of time: who, where, on which day, how it ended, and whether it was
    the first of its unit's visit.

    passed: it is valid, no element is missing, and its certificate passes it. adjusted: its unit
    was, since its run before.
    """
    table = pd.DataFrame.from_records(line_history.ended(home), columns=list(COLUMNS))
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
    for run, item, not_passed in line_history.decided_items(model, home):
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
            since=_monday(first.name), until=_monday(last.name) + timedelta(days=6),
            **_listed(table)[0].model_dump(),
        )  # fmt: skip


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
    for run, item, element, verdict in line_history.not_passed(model, home):
        if run in runs:
            (failed if verdict == "fail" else inconclusive)[item, element] += 1
    for run, reason in line_history.reasons(model, home):
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
    for item, element, unit in line_history.items(model, home):
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
