"""The page of a unit: its numbers are the catalogue's, and its drift that of its values."""

import re

import numpy as np
import pytest

from flows.pages.parts import View, seen_by
from flows.pages.unit import PAGE, UnitQuestion, UnitShown, data
from schemas.base import Unusable
from storage import dataframes
from storage.catalogue import certificates
from storage.home import Home
from tasks.stages.remind import interval_advice, sentence
from tasks.words import say
from tests.proof.line import Line


@pytest.fixture(scope="module")
def home(line_store: tuple[Home, Line]) -> Home:
    return line_store[0]


@pytest.fixture(scope="module")
def shown(home: Home) -> UnitShown:
    (unit,) = data(UnitQuestion(search="sn0000"), home).units
    return data(UnitQuestion(id=unit.id), home)


def test_units_are_found_by_any_words_of_their_names(home: Home) -> None:
    every = data(UnitQuestion(), home)
    assert (every.total, sum(each.runs for each in every.units)) == (2, 60)
    (found,) = data(UnitQuestion(search="0001 plant"), home).units
    assert found.serial == "SN0001"
    issued = [e for e in certificates.register(home) if e.serial == "SN0001"]
    newest = max((e for e in issued if e.state == "issued"), key=lambda e: str(e.calibrated_on))
    assert (found.certificate, found.due) == (newest.number, newest.due)
    assert data(UnitQuestion(search="% _"), home).total == 0


def test_every_value_and_u_is_that_of_the_catalogue(home: Home, shown: UnitShown) -> None:
    table = dataframes.results(home).set_index(["run", "item", "element"])
    of_unit = table[table["serial"] == "SN0000"]
    readings = [(e.item, e.element, r) for e in shown.elements for r in e.readings]
    assert len(readings) == len(of_unit)
    for item, element, reading in readings:
        row = of_unit.loc[(reading.run, item, element)]
        pairs = ((reading.value, row["value"]), (reading.U, row["expanded_uncertainty"]))
        for found, kept in pairs:
            assert (np.nan if found is None else found) == pytest.approx(kept, nan_ok=True)
    days = [r.day for r in shown.elements[0].readings]
    assert days == sorted(days)


def test_limits_are_those_of_the_certificate_that_counts(home: Home, shown: UnitShown) -> None:
    assert shown.unit is not None
    assert shown.limits_of == shown.unit.certificate
    record = certificates.find(shown.limits_of or "", home)
    stated = {(x.item, x.element): (x.lower, x.upper) for x in record.decision.limits
              if x.applied_to == "value"}  # fmt: skip
    assert {(e.item, e.element): (e.lower, e.upper) for e in shown.elements if e.upper} == stated


def test_drift_is_the_slope_of_the_valid_values_between_adjustments(shown: UnitShown) -> None:
    element = next(e for e in shown.elements if e.item == "accel_bias")
    valid = [r for r in element.readings if r.state != "invalid" and r.value is not None]
    levels = np.cumsum([r.state == "left" for r in valid])
    years = np.array([r.day.toordinal() for r in valid]) / 365.25
    design = np.column_stack([years, *(levels == level for level in np.unique(levels))])
    weight = 1 / np.array([r.U for r in valid], float)
    values = np.array([r.value for r in valid], float)
    slope = np.linalg.lstsq(design * weight[:, None], values * weight)[0][0]
    assert element.drift is not None
    assert element.drift.per_year == pytest.approx(slope, rel=1e-3)  # by U: k is not all the same
    assert element.drift.readings == len(valid)


def test_an_adjustment_has_the_runs_before_and_after_it(home: Home, shown: UnitShown) -> None:
    adjusted = {e.run for e in certificates.register(home) if "as-left" in (e.purpose or "")}
    some = [a for e in shown.elements for a in e.adjustments]
    assert some
    for each in some:
        assert each.left.run in adjusted
        assert each.found.day <= each.left.day
        assert each.found.run != each.left.run


def test_the_advice_is_that_of_the_command(home: Home, shown: UnitShown) -> None:
    assert shown.advice is not None
    assert shown.advice.en == say(sentence(*interval_advice("SN0000", home)), "en")


def test_a_page_has_one_unit_for_lengths_one_for_rates_and_one_for_accelerations(
    shown: UnitShown,
) -> None:
    page = str(seen_by(View(), PAGE.layout, shown, UnitQuestion(id=1)).to_plotly_json())
    cells = re.findall(r"TableTd\(children='[^']* ([^' ]+)'", page)
    used = {cell for cell in cells if re.fullmatch(r"[mµn]?m|°/[hs]|[mµ]?m/s²", cell)}
    assert used == {"mm", "°/s", "mm/s²"}


def test_what_there_is_not_is_said(home: Home) -> None:
    with pytest.raises(Unusable, match="There is no unit 77"):
        data(UnitQuestion(id=77), home)
    with pytest.raises(Unusable, match="an item 'none'"):
        data(UnitQuestion(id=1, item="none"), home)
