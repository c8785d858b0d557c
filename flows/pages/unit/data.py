"""Reads the history of one unit from the catalogue."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import date
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from pydantic import Field

from flows.pages.parts import place
from flows.pages.run.data import CertificateShown, certificate_shown
from schemas.base import Finite, Frozen, Unusable
from schemas.text import Statement
from storage import settings
from storage.catalogue import certificates, selection
from storage.catalogue.certificates import AS_LEFT, Entry
from storage.catalogue.selection import UnitLine
from storage.home import Home
from tasks.quality.charts import DriftRate, drift
from tasks.specifications.estimate import ITEMS, item_title, symbol
from tasks.stages.remind import NoAdvice, advice_by, sentence
from tasks.words import cause_of, message, statement

# One unit over the years, and the list of all units.

LISTED = 2000
AsMeasured = Literal["found", "left", "invalid"]


class UnitQuestion(Frozen):
    """A unit by its number in the catalogue, else the units with all words of `search`.

    item: whose history is drawn; the first where none is named.
    """

    id: int | None = Field(default=None, ge=1, le=2**31)
    item: str | None = Field(default=None, max_length=100)
    search: str = Field(default="", max_length=200)


class Reading(Frozen):
    """What one run found. state: as found, as left after an adjustment, or of an invalid run."""

    run: str
    day: date
    station: str | None
    state: AsMeasured
    value: Finite | None
    U: Finite | None


class AdjustmentShown(Frozen):
    """The value as found before an adjustment and as left after it, with the runs."""

    found: Reading
    left: Reading


class ElementHistory(Frozen):
    """An element over the years. lower, upper: limits that count now. value, U: of the last valid
    run.
    """

    item: str
    title: Statement
    element: str
    symbol: str
    unit: str
    lower: Finite | None
    upper: Finite | None
    value: Finite | None
    U: Finite | None
    drift: DriftRate | None
    readings: tuple[Reading, ...]
    adjustments: tuple[AdjustmentShown, ...]


class UnitShown(Frozen):
    """A unit, or the list. limits_of: the certificate whose limits stand beside the values;
    limits_by: the document of the model's limits, where no certificate has any. advice: on the
    interval of recalibration; why_no_advice: null where there is one.
    """

    total: int
    units: tuple[UnitLine, ...]
    unit: UnitLine | None = None
    item: str | None = None
    limits_of: str | None = None
    limits_by: str | None = None
    elements: tuple[ElementHistory, ...] = ()
    certificates: tuple[CertificateShown, ...] = ()
    advice: Statement | None = None
    why_no_advice: Statement | None = None


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
        total, lines = selection.unit_list(question.search, LISTED, home)
        return UnitShown(total=total, units=tuple(lines))
    line = selection.unit_line(question.id, home)
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
    edges = selection.limits_of(line.certificate, home) if line.certificate else {}
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
    runs = selection.runs_of(line.id, home)
    measured: dict[Element, dict[str, tuple[Any, ...]]] = defaultdict(dict)
    for run, item, element, *numbers in selection.readings_of(line.id, home):
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
