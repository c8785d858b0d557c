"""MIMUCAL_LOG=json: each event is a line of JSON on standard error; without it there is none."""

import json
import logging
from collections.abc import Iterator

import pytest

from flows.logs import set_up
from schemas.base import Unusable
from tasks.stages.events import logged, logger_of


@pytest.fixture(autouse=True)
def _as_before() -> Iterator[None]:
    root = logging.getLogger("mimucal")
    handlers, level = root.handlers[:], root.level
    root.handlers = []
    yield
    root.handlers, root.level, root.propagate = handlers, level, True


def test_beginning_and_end_of_a_stage_are_lines_of_json(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("MIMUCAL_LOG", "json")
    set_up()
    set_up()
    assert logged("check certificate", len)("MIMU-2026-0001") == 14
    begun, done = map(json.loads, capsys.readouterr().err.splitlines())
    assert (begun["logger"], begun["event"], begun["of"]) == (
        "check-certificate", "begun", "MIMU-2026-0001",
    )  # fmt: skip
    assert done["event"] == "done"
    assert done["seconds"] >= 0
    assert done["at"].endswith("+00:00")


def test_a_stage_that_fails_says_why_on_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails() -> None:
        raise Unusable("转台 is away\nfor good")

    monkeypatch.setenv("MIMUCAL_LOG", "json")
    set_up()
    with pytest.raises(Unusable):
        logged("acquire", fails)()
    last = json.loads(capsys.readouterr().err.splitlines()[-1])
    assert (last["level"], last["event"], last["cause"]) == (
        "error", "failed", "转台 is away\nfor good",
    )  # fmt: skip


def test_without_the_variable_nothing_is_written(capsys: pytest.CaptureFixture[str]) -> None:
    set_up()
    logger_of("remind").error("failed")
    assert capsys.readouterr().err == ""


def test_another_value_is_one_sentence(mimucal, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MIMUCAL_LOG", "xml")
    done = mimucal("runs")
    assert done.code == 2
    assert "MIMUCAL_LOG is 'xml'" in done.err
