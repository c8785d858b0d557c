"""What became of an order: said once to the operators, acknowledged by a person, in the trail."""

from datetime import timedelta
from pathlib import Path

import pytest

from flows.orders import production
from flows.orders.production import give, submit
from flows.pages.line_data import AlarmPressed, LineQuestion, acknowledge, line_now
from schemas.access import Visitor
from schemas.base import NotThere, Unusable
from schemas.orders import OrderRequest
from storage.catalogue import audit_trail, orders
from storage.home import Home
from tasks.stages.remind import Sent
from tasks.words import cause_of, message
from tests.flows.order_homes import add_station, no_workers

OPERATORS = """
format = "mimu-recall/1"
[operators]
language = "zh"
channels = {desk = "json://localhost/alerts"}
"""
LI = Visitor(name="Li", role="operator")


@pytest.fixture
def sent(home: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    sentences: list[str] = []
    add_station(home)
    no_workers(monkeypatch)
    (home / "recall.toml").write_text(OPERATORS, encoding="utf-8")

    def alert(_: Home, sentence: str, only: list[str]) -> list[Sent]:
        sentences.append(sentence)
        return [Sent(channel, None) for channel in only]

    monkeypatch.setattr(production, "alert", alert)
    for number in "12":
        fields = {"number": number, "station": "LINE-1", "units": [{"serial": f"S{number}"}]}
        give(OrderRequest.model_validate(fields), "Li", Home(home))
    return sentences


def actions(home: Path) -> list[tuple[str, str, str]]:
    found = audit_trail.entries(Home(home))
    return [(each.person, each.action, each.subject) for each in found]


def failed(home: Path) -> None:
    fault = Unusable(
        "unit S9 on socket://x: mount it", message("station-cause.busy", station="LINE-1")
    )
    orders.claim("1", Home(home))
    orders.finish("1", "failed", Home(home), str(fault), cause_of(fault))


def test_an_order_that_failed_is_said_once_for_each_attempt(home: Path, sent) -> None:
    failed(home)
    for _ in range(2):
        submit(Home(home))
    assert len(sent) == 1
    arguments = dict(sent[0].arguments)
    assert (arguments["station"], arguments["unit"]) == ("LINE-1", "S1")
    assert ("line", "alert", "1") in actions(home)
    orders.retry("1", "Li", Home(home))
    failed(home)
    submit(Home(home))
    assert len(sent) == 2


def test_an_alert_that_could_not_be_sent_is_sent_once_more_by_that_channel(
    home: Path, sent, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried: list[list[str]] = []

    def alert(_: Home, sentence: str, only: list[str]) -> list[Sent]:
        tried.append(only)
        return [Sent(each, "refused" if each == "desk" else None) for each in only]

    monkeypatch.setattr(production, "alert", alert)
    two = OPERATORS.replace("desk =", 'wall = "json://localhost/wall", desk =')
    (home / "recall.toml").write_text(two, encoding="utf-8")
    failed(home)
    for _ in range(3):
        submit(Home(home))
    assert tried == [["wall", "desk"], ["desk"]]
    assert actions(home).count(("line", "alert not sent", "1")) == 2


def test_an_order_that_nothing_takes_is_said_and_one_that_waits_its_turn_is_not(
    home: Path, sent, monkeypatch: pytest.MonkeyPatch
) -> None:
    submit(Home(home))
    assert sent == []
    monkeypatch.setattr(production, "LATE", timedelta())
    orders.claim("1", Home(home))
    submit(Home(home))
    assert sent == []  # order 2 waits for order 1
    orders.finish("1", "done", Home(home))
    submit(Home(home))
    assert [dict(each.arguments)["number"] for each in sent] == ["2"]


def test_a_person_acknowledges_an_alarm_and_another_failure_is_another_alarm(
    home: Path, sent
) -> None:
    failed(home)
    (alarm,) = line_now(LineQuestion(), Home(home)).alarms
    assert alarm.acknowledged is None
    assert "另一次采集" in alarm.cause.zh
    with pytest.raises(NotThere):
        acknowledge(AlarmPressed(alarm="0" * 16), LI, Home(home))
    acknowledge(AlarmPressed(alarm=alarm.key), LI, Home(home))
    (alarm,) = line_now(LineQuestion(), Home(home)).alarms
    assert alarm.acknowledged is not None
    assert alarm.acknowledged.by == "Li"
    assert ("Li", "acknowledge alarm", alarm.key) in actions(home)
    orders.retry("1", "Li", Home(home))
    failed(home)
    assert [each.acknowledged for each in line_now(LineQuestion(), Home(home)).alarms] == [None]


def test_stop_release_retry_and_cancel_are_in_the_trail_with_who(home: Path, sent, mimucal) -> None:
    failed(home)
    mimucal("station", "stop", "LINE-1", "--by", "Wang")
    assert mimucal("station", "release", "LINE-1", "--by", "Zhao").code == 0
    mimucal("order", "retry", "1", "--by", "Li")
    mimucal("order", "cancel", "2", "--by", "Li")
    found = [each for each in actions(home) if each[1] != "order acquire" or each[2] == "1"]
    assert ("Wang", "stop station", "LINE-1") in found
    assert ("Zhao", "release station", "LINE-1") in found
    assert ("Li", "cancel order", "2") in found
    assert found.count(("Li", "order acquire", "1")) == 2


def test_a_cause_on_a_page_names_neither_a_command_nor_a_folder_and_is_no_english_in_chinese() -> (
    None
):
    stopped = Unusable("a run is going on (process 3): wait, or end it with `mimucal station stop`")
    assert cause_of(stopped).en == "a run is going on (process 3)"
    assert cause_of(stopped).zh == "原因见日志。"
    assert cause_of(Unusable("/a/b/line.toml: id is missing")).en == "line.toml: id is missing"
    tripped = "the table tripped on axis 2 (see a.log; start again with `mimucal acquire`)"
    assert cause_of(tripped).en == "the table tripped on axis 2"
    worded = Unusable("see `mimucal doctor`", message("station-cause.no-worker"))
    later = Unusable("the run stopped; recorded so far: /a/b.mcap")
    later.__cause__ = worded
    assert "Prefect" in cause_of(later).zh
