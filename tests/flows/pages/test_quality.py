"""The quality page: its numbers are the catalogue's, counted here a second time by hand."""

import io
import re
import shutil
from collections import Counter
from datetime import timedelta
from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from flows.pages.app import make_app
from flows.pages.login import hashed
from flows.pages.parts import View, csv_of, seen_by
from flows.pages.quality import PAGE
from flows.pages.quality_data import QualityQuestion, QualityShown, data
from schemas.base import Unusable
from storage import dataframes
from storage.catalogue import certificates, results, runs, users
from storage.home import Home
from tasks.quality import FEWEST
from tests.drafts import DECIDED, UNDECIDED, draft
from tests.proof.line import Line

ELEMENT = {"item": "accel_rate_sensitivity", "element": "yz"}
OF = QualityQuestion(model="MX-110", **ELEMENT)


@pytest.fixture(scope="module")
def home(line_store: tuple[Home, Line]) -> Home:
    return line_store[0]


@pytest.fixture(scope="module")
def shown(home: Home) -> QualityShown:
    return data(OF, home)


def visits(home: Home, model: str) -> tuple[list[str], set[str]]:
    """First runs that count, and those of them that passed, by their ids."""
    runs = dataframes.runs(home).sort_values("imported_at")
    papers = dataframes.certificates(home).set_index("run")["verdict"].to_dict()
    valid = dataframes.results(home)
    whole = {run: group["value"].notna().all() for run, group in valid.groupby("run")}
    counted, passed, last = [], set(), None
    for row in runs[runs["model"] == model].itertuples():
        first = last is None or row.recorded_on - last > timedelta(days=7)
        last = row.recorded_on
        invalid = row.id not in papers and row.id in _invalid(home)
        if first and (row.id in papers or invalid):
            counted.append(row.id)
            if papers.get(row.id) == "pass" and whole[row.id]:
                passed.add(row.id)
    return counted, passed


def _invalid(home: Home) -> set[str]:
    of_runs = [each for run in runs.all_runs(home) for each in results.of_run(run, home)]
    return {each.run for each in of_runs if each.calibration.validity.verdict == "invalid"}


def test_yields_are_those_of_the_catalogue(home: Home, shown: QualityShown) -> None:
    counted, passed = visits(home, "MX-110")
    assert shown.total is not None
    assert (shown.total.passed, shown.total.of) == (len(passed), len(counted))
    assert shown.counted.runs == 30
    assert shown.counted.first + shown.counted.retests == 30
    for part in (shown.by_station, shown.by_week):
        assert sum(each.of for each in part) == len(counted)
        assert sum(each.passed for each in part) == len(passed)
    assert {each.of for each in shown.by_item} == {len(counted)}
    assert all(each.passed >= len(passed) for each in shown.by_item)
    assert [each.name for each in shown.by_model] == ["MX-110", "MX-120"]


def test_capability_is_that_of_the_values_of_first_runs(home: Home, shown: QualityShown) -> None:
    values = dataframes.results(home)
    of = values[(values["item"] == ELEMENT["item"]) & (values["element"] == ELEMENT["element"])]
    assert shown.chart is not None
    charted = {point.run: point.value for point in shown.chart.points}
    table = of.set_index("run")["value"].to_dict()
    assert charted == pytest.approx({run: table[run] for run in charted})
    assert set(of[of["model"] == "MX-110"]["run"]) - set(charted) <= _invalid(home)
    found = shown.capability
    assert found is not None
    assert (found.lower, found.upper) == (-0.0014, 0.0014)
    assert found.overall is not None
    assert found.pp.value == pytest.approx(0.0028 / 6 / found.overall)
    assert found.n <= shown.counted.first - shown.counted.invalid
    assert found.margin_median is not None
    assert 0.05 < found.margin_median < 1.0


def test_changes_leave_out_what_a_unit_is_by_itself(home: Home, shown: QualityShown) -> None:
    changed = data(OF.model_copy(update={"plot": "change"}), home).chart
    assert changed is not None
    assert shown.chart is not None
    values = {point.run: point.value for point in shown.chart.points}
    runs = [point.run for point in shown.chart.points]  # one unit: successive runs
    steps = dict(zip(runs[1:], np.diff([values[run] for run in runs]), strict=True))
    for point in changed.points:
        assert point.value == pytest.approx(steps[point.run])


def test_causes_are_those_of_the_register_and_of_the_unit(home: Home) -> None:
    renewed = set()
    for station in data(OF, home).choices.stations:
        there = data(OF.model_copy(update={"station": station}), home).chart
        assert there is not None
        assert {each.cause for each in there.events} <= {"adjusted", "equipment"}
        names = {each.name for each in there.events if each.cause == "equipment"}
        assert names <= {f"TT-{station}"}
        renewed |= names
    assert renewed
    unit = data(OF.model_copy(update={"serial": "SN0000"}), home).chart
    assert unit is not None
    moves = [each for each in unit.events if each.cause == "station"]
    stations = [point.station for point in unit.points]
    assert len(moves) == sum(a != b for a, b in pairwise(stations))


@pytest.mark.parametrize("asked", [
    {"model": "none"}, {"item": "none"}, {"element": "none"}, {"station": "none"},
    {"serial": "none"},
])  # fmt: skip
def test_what_the_catalogue_does_not_have_is_said(home: Home, asked: dict[str, str]) -> None:
    with pytest.raises(Unusable, match=r"there is no .* 'none'; there are"):
        data(QualityQuestion(**asked), home)


def test_what_fails_is_counted_by_limit_and_adds_up(home: Home, shown: QualityShown) -> None:
    counted, _ = visits(home, "MX-110")
    expected: Counter[tuple[str | None, str]] = Counter()
    invalid = _invalid(home)
    expected[None, "Run invalid"] = sum(run in invalid for run in counted)
    papers = {entry.run: entry for entry in certificates.register(home)}
    for run in set(counted) - invalid:
        for each in certificates.record_of(papers[run], home).decision.limits:
            expected[each.item, each.element] += each.verdict != "pass"
    of_limits = [each for each in shown.failing if each.item or each.title.en == "Run invalid"]
    found = {(e.item, e.element or e.title.en): e.failed + e.inconclusive for e in of_limits}
    assert found == +expected
    sizes = [each.failed + each.inconclusive for each in shown.failing]
    assert sizes == sorted(sizes, reverse=True)
    assert not shown.failing or shown.failing[-1].cumulative == pytest.approx(1.0)


def test_units_on_which_nothing_is_decided_count_with_their_reasons(tmp_path: Path) -> None:
    home = Home(tmp_path)
    for serial, decision in (("1", UNDECIDED), ("2", UNDECIDED), ("3", DECIDED)):
        draft(home, serial, bias=0.1 * int(serial), decision=decision)
    found = data(QualityQuestion(), home)
    assert found.total is not None
    assert (found.total.passed, found.total.of) == (1, 3)
    assert (found.counted.passed, found.counted.inconclusive) == (1, 2)
    assert [(e.title.zh, e.failed, e.inconclusive) for e in found.failing] == [
        ("未提供该型号的允许限", 0, 2)
    ]
    assert "2 are inconclusive" in laid_out(found)
    assert found.capability is not None
    assert (found.capability.n, found.capability.cp.value) == (3, None)
    assert "at least 10 are needed" in laid_out(found)
    assert "no unit of this model was run on two stations" in laid_out(found)
    assert "'name': 'quality-stations'" not in laid_out(found)


@pytest.fixture(scope="module")
def golden(home: Home, tmp_path_factory: pytest.TempPathFactory) -> Home:
    """The same store, in which one of the two units is golden."""
    made = Home(tmp_path_factory.mktemp("golden") / "home")
    shutil.copytree(home.path, made.path)
    (made.path / "quality.toml").write_text('golden = ["SN0000"]\n', encoding="utf-8")
    return made


def test_a_golden_unit_counts_in_no_yield_and_no_capability(home: Home, golden: Home) -> None:
    model = data(QualityQuestion(serial="SN0000"), home).model
    runs = data(QualityQuestion(model=model, **ELEMENT), home)
    kept = data(QualityQuestion(model=model, **ELEMENT), golden)
    assert kept.counted.golden == runs.counted.runs
    assert (kept.counted.first, kept.total, kept.by_period, kept.failing) == (0, None, (), ())
    assert model not in {each.name for each in kept.by_model}
    assert kept.capability is not None
    assert kept.capability.n == 0
    assert kept.chart is None
    assert kept.stations == runs.stations  # which it compares all the same


def test_a_golden_unit_is_charted_for_each_station(home: Home, golden: Home) -> None:
    asked = QualityQuestion(serial="SN0000", **ELEMENT)
    chart, found = data(asked, home).chart, data(asked, golden).golden
    assert chart is not None
    values = {point.run: (point.station, point.value) for point in chart.points}
    stations = [each.station for each in found]
    assert stations == sorted(set(stations))
    for of in found:
        assert of.serial == "SN0000"
        assert [values[p.run] for p in of.points] == [(of.station, p.value) for p in of.points]
        assert (of.centre is None) == (len(of.points) < FEWEST)
    assert seen_by(View("zh"), PAGE.layout, data(asked, golden), asked).to_plotly_json()


def test_each_table_and_chart_gives_its_numbers_as_csv(home: Home, shown: QualityShown) -> None:
    client = make_app(home).server.test_client()
    links = set(re.findall(r"/api/v1/quality/([a-z_]+)\.csv\?([^'\"]*)", laid_out(shown)))
    assert {part for part, _ in links} == set(PAGE.numbers) - {"golden"}  # of which there is none
    for part, query in links:
        answer = client.get(f"/api/v1/quality/{part}.csv?{query}")
        assert answer.status_code == 200
        assert answer.mimetype == "text/csv"
        table = pd.read_csv(io.BytesIO(answer.data))
        assert len(table) == len(PAGE.numbers[part](shown))
    table = pd.read_csv(
        io.BytesIO(
            client.get(
                f"/api/v1/quality/chart.csv?model=MX-110&item={ELEMENT['item']}&element=yz"
            ).data
        )
    )
    assert shown.chart is not None
    assert table["value"].tolist() == [point.value for point in shown.chart.points]
    assert client.get("/api/v1/quality/chart.csv?model=none").status_code == 400


def laid_out(shown: QualityShown) -> str:
    return str(seen_by(View(), PAGE.layout, shown, OF).to_plotly_json())


def test_numbers_are_for_those_alone_who_may_see_the_page(tmp_path: Path) -> None:
    home = Home(tmp_path)
    users.add("Wang", "viewer", hashed("secret"), home, "Admin")
    client = make_app(home).server.test_client()
    assert client.get("/api/v1/quality/by_item.csv").status_code == 401
    assert client.get("/api/v1/quality/by_item.csv", auth=("Wang", "secret")).status_code == 200


def test_a_name_that_a_spreadsheet_would_compute_is_text() -> None:
    written = csv_of([{"serial": "=1+1", "value": -0.5, "broken": [1, 2]}])
    assert written.splitlines() == ["\ufeffserial,value,broken", "'=1+1,-0.5,1 2"]
