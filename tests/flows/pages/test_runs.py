"""The list of runs: what it says of each, and what its filters find."""

from datetime import UTC, date, datetime
from itertools import product
from pathlib import Path
from typing import get_args

import pytest

from flows.pages.parts import View, result_state, seen_by, validity_state, verdict_state
from flows.pages.runs import (
    RunsQuestion,
    columns,
    conditions_from,
    conditions_of,
    data,
    filter_model,
)
from schemas.base import Unusable
from schemas.certificate import State
from schemas.text import RunVerdict
from storage.catalogue import results
from storage.catalogue.run_states import Condition, ResultState, RunLine, run_list
from storage.catalogue.runs import add
from storage.home import Home
from tests.drafts import calibration_of, draft, recording_of

LINE = RunLine(
    id="r1", recording_id="run", unit=1, manufacturer="M", model="U", serial="1", station="T1",
    procedure=None, standard="other", recorded_on=date(2026, 1, 2),
    imported_at=datetime(2026, 1, 2, tzinfo=UTC), seconds=3.0, result="c1", method="jjf2003",
    made_at=None, validity="valid", missing=0, fault=None, result_state="whole",
    certificate="A-1", state="issued", verdict="pass", due=None,
)  # fmt: skip


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Home:
    """Two units with drafts, and one with a recording alone."""
    home = Home(tmp_path_factory.mktemp("runs"))
    draft(home, "Ab%1")
    draft(home, "Ab_2")
    add(recording_of("<script>alert(1)</script>"), home)
    return home


def serials(home: Home, *conditions: Condition) -> list[str]:
    return sorted(run.serial for run in run_list(conditions, [], 0, 100, home)[1])


def test_what_an_operator_looks_for_stands_within_the_width_of_a_tablet() -> None:
    shown, width = [], 0
    for column in seen_by(View(), columns):
        width += column["width"]
        if width <= 780:
            shown.append(column["field"])
    assert {"id", "serial", "station", "validity", "verdict", "state"} <= set(shown)


def test_nothing_that_failed_is_missing_or_invalid_is_good() -> None:
    for validity, state, result, fault in product(
        (*get_args(RunVerdict), None), (*get_args(State), None), get_args(ResultState),
        (None, "broken"),
    ):  # fmt: skip
        run = LINE.model_copy(
            update={"validity": validity, "state": state, "result_state": result, "fault": fault}
        )
        sound = validity == "valid" and fault is None
        if verdict_state(run).kind == "good":
            assert sound
            assert state in ("draft", "checked", "issued")
        if result_state(run).kind == "good":
            assert result == "whole"
            assert validity != "invalid"
        assert (validity_state(validity).kind == "good") == (validity == "valid")
    for verdict in ("fail", "inconclusive", None):
        assert verdict_state(LINE.model_copy(update={"verdict": verdict})).kind != "good"


def test_a_run_is_listed_with_its_result_and_certificate(store: Home) -> None:
    shown = data(RunsQuestion(serial="Ab_2"), store)
    (run,) = shown.runs
    assert shown.total == 1
    assert (run.validity, run.missing, run.verdict, run.state) == ("valid", 0, "pass", "draft")
    (alone,) = data(RunsQuestion(serial="<script>alert(1)</script>"), store).runs
    assert (alone.result, alone.validity, alone.verdict, alone.state) == (None,) * 4


def test_filters_find_text_as_it_stands(store: Home) -> None:
    assert serials(store, Condition(column="serial", kind="contains", value="b_")) == ["Ab_2"]
    assert serials(store, Condition(column="serial", kind="begins", value="aB%")) == ["Ab%1"]
    without = Condition(column="serial", kind="not_contains", value="ab")
    assert serials(store, without) == ["<script>alert(1)</script>"]
    either = Condition(column="serial", any_of=(without, Condition(column="serial", value="ab%1")))
    assert len(serials(store, either)) == 2


def test_filters_on_numbers_days_and_what_is_missing(store: Home) -> None:
    today = datetime.now(UTC).date()
    assert len(serials(store, Condition(column="imported_at", kind="equals", value=today))) == 3
    assert serials(store, Condition(column="seconds", kind="greater", value=10.0)) == []
    missing = Condition(column="state", kind="among", values=(None,))
    assert serials(store, missing) == ["<script>alert(1)</script>"]
    with pytest.raises(Unusable, match="no column 'nothing'"):
        serials(store, Condition(column="nothing"))


def test_runs_are_found_by_how_far_their_result_is(store: Home, tmp_path: Path) -> None:
    whole = Condition(column="result_state", value="whole")
    assert serials(store, whole) == ["Ab%1", "Ab_2"]
    words = {"result_state": {"filterType": "text", "type": "equals", "filter": "no result"}}
    assert serials(store, *seen_by(View("en"), conditions_from, words)) == [
        "<script>alert(1)</script>"
    ]
    other = Home(tmp_path / "home")
    run, _ = add(recording_of("partly"), other)
    results.save(calibration_of(run, bias=None), other)
    (line,) = data(RunsQuestion(result_state="partial"), other).runs
    assert (line.serial, line.missing) == ("partly", 1)


def test_blocks_and_order_are_those_of_the_whole_list(store: Home) -> None:
    order = [("serial", True)]
    total, every = run_list([], order, 0, 100, store)
    assert total == 3
    assert [run.serial for run in every] == sorted((run.serial for run in every), reverse=True)
    assert [run_list([], order, start, 1, store)[1][0] for start in range(3)] == every


@pytest.mark.parametrize("language", ["en", "zh"])
def test_a_question_and_the_grids_own_filters_ask_the_same(language: str) -> None:
    view = View(language)
    question = RunsQuestion(station="T3", verdict="fail", since=date(2026, 1, 1))
    asked = seen_by(view, conditions_from, seen_by(view, filter_model, question))
    assert [each.column for each in asked] == ["station", "verdict", "recorded_on"]
    assert asked[1] == Condition(column="verdict", kind="among", values=("fail",))
    assert asked[2] == conditions_of(question)[2]


def test_a_home_that_holds_nothing_has_no_runs_and_none_is_made(tmp_path: Path) -> None:
    assert data(RunsQuestion(), Home(tmp_path / "none")).total == 0
    assert not (tmp_path / "none").exists()
