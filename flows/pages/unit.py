"""The page of one unit: every coefficient over the years, drift, certificates and next due date."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from itertools import pairwise
from typing import Any, Literal

import dash_mantine_components as dmc
import numpy as np
from dash.development.base_component import Component
from pydantic import Field

from flows.pages.due import due_state
from flows.pages.parts import (
    BLUE,
    GREY,
    ORANGE,
    RED,
    Figure,
    Page,
    StepState,
    badge,
    choice,
    decision_state,
    facts,
    figure,
    grid,
    heading,
    link,
    note,
    picture,
    place,
    said,
    say,
    stated,
    table,
)
from flows.pages.run import certificate_table
from flows.pages.run_data import CertificateShown, certificate_shown
from schemas.base import Finite, Frozen, Unusable
from schemas.text import Statement
from storage import settings
from storage.catalogue import certificates, selection
from storage.catalogue.certificates import AS_LEFT, Entry
from storage.catalogue.selection import UnitLine
from storage.home import Home
from tasks.conformity.limits import interval_text
from tasks.quality import DriftRate, drift
from tasks.specifications.estimate import ITEMS, item_title, symbol
from tasks.stages.remind import NoAdvice, advice_by, sentence
from tasks.words import cause_of, message, statement
from tasks.words.numbers import Scale, common_scales, exact, quantity, unit_text

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
        readings = [_reading(run, of_runs[run[0]]) for run in runs if run[0] in of_runs]
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


# Lays the page of one unit, or the list of units, out.


Scales = dict[str, Scale]  # by the unit of the values
OWN: dict[str, dict[str, Any]] = {
    "serial": {"cellRenderer": "UnitLink"},
    "certificate": {"minWidth": 165},
    "runs": {"filter": "agNumberColumnFilter"},
    **{each: {"cellRenderer": "State", "minWidth": 140} for each in ("verdict", "due")},
}
ACROSS, PANEL_PX, GAP = 3, 230, 0.08
COLORS: dict[AsMeasured, str] = {"found": BLUE, "left": ORANGE, "invalid": GREY}
SYMBOLS: dict[AsMeasured, str] = {"found": "circle", "left": "diamond", "invalid": "x"}


def layout(shown: UnitShown, question: UnitQuestion) -> Component:
    """One unit where it is named, else the list."""
    if shown.unit is None:
        names = "serial model manufacturer runs last-run certificate verdict due"
        rows = [_row(each) for each in shown.units]
        shown_units = grid(
            "units", "pages-unit-column", names, rows, "calc(100vh - 190px)", 120, OWN
        )
        count = said("pages-unit-count", count=shown.total)
        return dmc.Stack([dmc.Text(count), shown_units], gap="xs")
    sentence = say(shown.advice or shown.why_no_advice or "")
    name = dmc.Text(said("pages-unit-interval"), size="xs", c="dimmed")
    parts = [_facts(shown.unit), dmc.Box([name, dmc.Text(sentence, size="sm")])]
    if shown.elements:
        parts += [_choice(shown), *_history(shown)]
    else:
        parts.append(dmc.Text(said("pages-unit-no-result")))
    return dmc.Stack(
        [
            *parts,
            heading("pages-unit-heading.certificates"),
            certificate_table(shown.certificates),
        ]
    )


def _row(line: UnitLine) -> dict[str, Any]:
    verdict, due = decision_state(line.verdict), due_state(line.due)
    return {
        "unit": line.id, "serial": line.serial, "model": line.model, "runs": line.runs,
        "manufacturer": line.manufacturer, "last-run": line.last_run and str(line.last_run),
        "certificate": line.certificate, "verdict": say(verdict.words),
        "verdict_kind": verdict.kind, "due": str(line.due or "–"), "due_kind": due.kind,
    }  # fmt: skip


def _facts(line: UnitLine) -> Component:
    due = due_state(line.due)
    runs = link(str(line.runs), "/runs", manufacturer=line.manufacturer, model=line.model,
                serial=line.serial)  # fmt: skip
    return facts(
        {
            "pages-unit-column.manufacturer": line.manufacturer,
            "pages-unit-column.model": line.model,
            "pages-unit-column.serial": line.serial,
            "pages-unit-column.runs": runs,
            "pages-unit-column.last-run": str(line.last_run or "–"),
            "pages-unit-column.certificate": line.certificate,
            "pages-unit-column.verdict": badge(decision_state(line.verdict)),
            "pages-unit-column.due": dmc.Group(
                [dmc.Text(str(line.due or "–")), badge(due)], gap="xs"
            ),
        },
    )


def _choice(shown: UnitShown) -> Component:
    titles = {each.item: say(each.title) for each in shown.elements}
    items = [{"value": item, "label": title} for item, title in titles.items()]
    return dmc.Box(choice("item", "pages-unit-item", items, shown.item), maw=480)


def _history(shown: UnitShown) -> list[Component]:
    of_item = [each for each in shown.elements if each.item == shown.item]
    scales = _scales(shown.elements)
    if shown.limits_of:
        limits = message("pages-unit-limits.certificate", certificate=shown.limits_of)
    elif shown.limits_by:
        limits = message("pages-unit-limits.document", document=shown.limits_by)
    else:
        limits = message("pages-unit-limits.none")
    return [
        note(say(limits)),
        picture("unit-history", history_figure(of_item, scales)),
        heading("pages-unit-heading.drift"),
        note(said("pages-unit-drift-about")),
        _drifts(shown, scales),
        heading("pages-unit-heading.adjustments"),
        _adjustments(of_item, scales),
    ]


def _scales(elements: Sequence[ElementHistory]) -> Scales:
    """One unit for all lengths of the page, and one for all rates."""
    return common_scales(
        (size, of.unit)
        for of in elements
        for size in (of.value, of.U, of.lower, of.upper, *(each.value for each in of.readings))
    )


def _drifts(shown: UnitShown, scales: Scales) -> Component:
    names = "item symbol value limits drift readings state"
    rows = [_element(each, scales.get(each.unit)) for each in shown.elements]
    return table("pages-unit-drift", names, rows)


def _element(of: ElementHistory, scale: Scale | None) -> tuple[Any, ...]:
    found = of.drift
    return (
        say(of.title),
        of.symbol,
        None if of.value is None else quantity(of.value, of.U, of.unit, scale),
        _limits_text(of, scale or Scale(1.0, 0, of.unit)),
        found and quantity(found.per_year, found.U, of.unit, scale),
        found and str(found.readings),
        badge(_drift_state(found)),
    )


def _limits_text(of: ElementHistory, scale: Scale) -> str | None:
    if of.lower is None and of.upper is None:
        return None
    lower, upper = (
        None if edge is None else exact(float(f"{edge * scale.factor:.9g}"))
        for edge in (of.lower, of.upper)
    )
    unit = "" if scale.unit == "1" else f" {unit_text(scale.unit)}"
    return interval_text(lower, upper) + unit


def _drift_state(found: DriftRate | None) -> StepState:
    if found is None:
        return stated("pages-unit-drifts.open", "none")
    drifts = abs(found.per_year) > found.U
    words = f"pages-unit-drifts.{'yes' if drifts else 'no'}"
    return stated(words, "open" if drifts else "good")


def _adjustments(of_item: list[ElementHistory], scales: Scales) -> Component:
    def text(of: ElementHistory, one: Reading) -> str | None:
        scale = scales.get(of.unit)
        return None if one.value is None else quantity(one.value, one.U, of.unit, scale)

    rows = [
        (
            str(each.left.day),
            element.symbol,
            text(element, each.found),
            text(element, each.left),
            link(each.found.run, "/run", id=each.found.run),
            link(each.left.run, "/run", id=each.left.run),
        )
        for element in of_item
        for each in element.adjustments
    ]
    return table(
        "pages-unit-adjustment",
        "day symbol found left run-found run-left",
        rows,
        none="pages-unit-not-adjusted",
    )


def history_figure(elements: Sequence[ElementHistory], scales: Scales) -> Figure:
    """Values with U over the years, limits dotted; as left and invalid in their own colours."""
    down = -(-len(elements) // ACROSS)
    axes: dict[str, Any] = {}
    traces, shapes, titles = [], [], []
    shown: set[AsMeasured] = set()
    for number, element in enumerate(elements):
        end = "" if number == 0 else str(number + 1)
        axes |= _axes(number, down, end, element)
        scale = scales.get(element.unit) or Scale(1.0, 0, element.unit)
        x, y = _domains(number, down)
        titles.append(
            {
                "text": element.symbol
                if scale.unit == "1"
                else f"{element.symbol} ({unit_text(scale.unit)})",
                "x": x[0],
                "y": y[1],
                "xref": "paper",
                "yref": "paper",
                "xanchor": "left",
                "yanchor": "bottom",
                "showarrow": False,
            }
        )
        edges = [edge for edge in (element.lower, element.upper) if edge is not None]
        shapes += [_limit(edge * scale.factor, end) for edge in edges]
        for state in COLORS:
            of = [
                each for each in element.readings if each.state == state and each.value is not None
            ]
            if of:
                traces.append(_points(of, state, end, state not in shown, scale.factor))
                shown.add(state)
    return figure(
        traces, 90 + PANEL_PX * down, shapes=shapes, showlegend=True,
        legend={"orientation": "h", "y": 1.0, "yref": "container", "yanchor": "top", "x": 0},
        annotations=titles,
        margin={"t": 60, "r": 15, "l": 65, "b": 35}, **axes,
    )  # fmt: skip


def _domains(number: int, down: int) -> tuple[list[float], list[float]]:
    """From left to right and from the top down."""
    row, column = divmod(number, ACROSS)
    width = (1.0 - GAP * (ACROSS - 1)) / ACROSS
    gap = 0.22 / down
    height = (1.0 - gap * (down - 1)) / down
    left, top = column * (width + GAP), 1.0 - row * (height + gap)
    return [left, left + width], [max(top - height, 0.0), top]


def _axes(number: int, down: int, end: str, element: ElementHistory) -> dict[str, Any]:
    x, y = _domains(number, down)
    return {
        f"xaxis{end}": {"domain": x, "anchor": f"y{end}", "tickformat": "%Y-%m", "nticks": 4,
                        "type": "date"},
        f"yaxis{end}": {"domain": y, "anchor": f"x{end}", "exponentformat": "power", "nticks": 6},
    }  # fmt: skip


def _points(
    readings: Sequence[Reading], state: AsMeasured, end: str, in_legend: bool, factor: float
) -> Figure:
    return {
        "type": "scatter", "mode": "markers", "xaxis": f"x{end}", "yaxis": f"y{end}",
        "x": [str(each.day) for each in readings],
        "y": [(each.value or 0.0) * factor for each in readings],
        "error_y": {"type": "data", "array": [(each.U or 0.0) * factor for each in readings],
                    "width": 0, "thickness": 1},
        "marker": {"color": COLORS[state], "symbol": SYMBOLS[state], "size": 5},
        "customdata": [each.run for each in readings],
        "text": [f"{each.run}, {each.station or '–'}" for each in readings],
        "hovertemplate": "%{x}: %{y:.6g}<br>%{text}<extra></extra>",
        "name": said(f"pages-unit-state.{state}"), "legendgroup": state,
        "showlegend": in_legend,
    }  # fmt: skip


def _limit(edge: float, end: str) -> dict[str, Any]:
    return {
        "type": "line", "xref": f"x{end} domain", "x0": 0, "x1": 1, "yref": f"y{end}", "y0": edge,
        "y1": edge, "line": {"color": RED, "width": 1, "dash": "dot"},
    }  # fmt: skip


PAGE = Page("unit", UnitQuestion, UnitShown, data, layout, has_grid=True)
