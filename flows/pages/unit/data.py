"""Reads the history of one unit from the catalogue."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from flows.pages.run.data import certificate_shown
from flows.pages.specification_order import place
from flows.pages.unit.models import (
    LISTED,
    AdjustmentShown,
    AsMeasured,
    ElementHistory,
    Reading,
    UnitQuestion,
    UnitShown,
)
from schemas.base import Unusable
from storage import settings
from storage.catalogue import certificates, units
from storage.catalogue.certificates import AS_LEFT, Entry
from storage.catalogue.units import UnitLine
from storage.home import Home
from tasks.quality.charts import DriftRate, drift
from tasks.specifications.items import ITEMS, item_title, symbol
from tasks.stages.remind import NoAdvice, advice_by, sentence
from tasks.words import cause_of, message, statement

YEAR_D = 365.25
Element = tuple[str, str]  # item, element
Edges = tuple[float | None, float | None]


@dataclass(frozen=True)
class _Limits:
    """Limits by element, and the certificate or the document that they are of."""

    edges: Mapping[Element, Edges]
    certificate: str | None = None
    document: str | None = None


def data(question: UnitQuestion, home: Home) -> UnitShown:
    """A unit, or the units that are searched for; raises Unusable for a number that none has."""
    if question.id is None:
        total, lines = units.unit_list(question.search, LISTED, home)
        return UnitShown(total=total, units=tuple(lines))
    line = units.unit_line(question.id, home)
    entries, limits = certificates.of_unit(line.id, home), _limits(line, home)
    elements = tuple(_elements(line, limits, home))
    items = list(dict.fromkeys(each.item for each in elements))
    if question.item is not None and question.item not in items:
        raise Unusable(
            f"no run of this unit has an item {question.item!r}; there are {', '.join(items)}",
            message("cause-none.choice", name=question.item, known=", ".join(items)),
        )
    return UnitShown(
        total=1, units=(line,), unit=line, item=question.item or next(iter(items), None),
        limits_of=limits.certificate, limits_by=limits.document, elements=elements,
        certificates=tuple(map(certificate_shown, reversed(entries))),
        **_advice(entries, line, home),
    )  # fmt: skip


def _advice(entries: list[Entry], line: UnitLine, home: Home) -> dict[str, Any]:
    try:
        return {"advice": statement(sentence(*advice_by(entries, line.serial, home)))}
    except NoAdvice as error:
        return {"why_no_advice": statement(error.why)}
    except Unusable as error:
        return {"why_no_advice": cause_of(error)}


def _limits(line: UnitLine, home: Home) -> _Limits:
    """Of the issued certificate that counts, else of the model."""
    edges = units.limits_of(line.certificate, home) if line.certificate else {}
    if edges:
        return _Limits(edges, certificate=line.certificate)
    tolerance = settings.tolerance_for(line.manufacturer, line.model, home)
    if tolerance is None:
        return _Limits({})
    stated = {
        (limit.item, element): limit.bounds
        for limit in tolerance.limits
        if limit.applied_to == "value" and limit.item in ITEMS
        for element in limit.elements or ITEMS[limit.item].elements
    }
    return _Limits(stated, document=tolerance.document)


def _elements(line: UnitLine, limits: _Limits, home: Home) -> Iterator[ElementHistory]:
    runs = units.runs_of(line.id, home)
    measured: dict[Element, dict[str, tuple[Any, ...]]] = defaultdict(dict)
    for run, item, element, *numbers in units.readings_of(line.id, home):
        measured[item, element][run] = tuple(numbers)
    for item, element in sorted(measured, key=lambda of: place(*of)):
        of_runs = measured[item, element]
        readings = [
            _reading(run, of_runs[run[0]]) for run in runs if run[0] in of_runs
        ]  # fmt: skip
        sound = [each for each in readings if each.state != "invalid"]
        newest = next((each for each in reversed(sound) if each.value is not None), None)
        lower, upper = limits.edges.get((item, element), (None, None))
        yield ElementHistory(
            item=item, title=statement(item_title(item)), element=element,
            symbol=symbol(item, element), unit=next(iter(of_runs.values()))[4],
            lower=lower, upper=upper, value=newest.value if newest else None,
            U=newest.U if newest else None,
            drift=_drift(sound, {run: numbers[1] for run, numbers in of_runs.items()}),
            readings=tuple(readings),
            adjustments=tuple(
                AdjustmentShown(found=before, left=after)
                for before, after in pairwise(sound)
                if after.state == "left"
            ),
        )  # fmt: skip


def _reading(run: tuple[Any, ...], numbers: tuple[Any, ...]) -> Reading:
    name, day, station, validity, purpose = run
    state: AsMeasured = "left" if AS_LEFT in (purpose or "").split() else "found"
    return Reading(
        run=name, day=day, station=station, value=numbers[0], U=numbers[2],
        state="invalid" if validity == "invalid" else state,
    )  # fmt: skip


def _drift(readings: list[Reading], u: Mapping[str, float | None]) -> DriftRate | None:
    years = [each.day.toordinal() / YEAR_D for each in readings]
    values = [_number(each.value) for each in readings]
    adjustments = np.cumsum([each.state == "left" for each in readings], dtype=int)
    stated = [_number(u[each.run]) for each in readings]
    return drift(np.array(years), np.array(values), np.array(stated), adjustments)


def _number(number: float | None) -> float:
    return np.nan if number is None else number
