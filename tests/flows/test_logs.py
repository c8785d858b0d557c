"""MIMUCAL_LOG and MIMUCAL_LOG_LEVEL: events as lines on standard error; without them none."""

import asyncio
import json
import logging

import pytest

from flows.logs import set_up
from schemas.base import Unusable
from tasks.stages.stage import logged, logger_of
from tasks.station.connected_station import Bus, OnBus, StopSwitch, bus


def test_beginning_and_end_of_a_stage_are_lines_of_json(monkeypatch, capsys):
    monkeypatch.setenv("MIMUCAL_LOG", "json")
    set_up()
    set_up()
    assert logged("check certificate", len)("MIMU-2026-0001") == 14
    begun, done = map(json.loads, capsys.readouterr().err.splitlines())
    assert (begun["logger"], begun["event"], begun["of"]) == (
        "stage.check-certificate", "begun", "MIMU-2026-0001",
    )  # fmt: skip
    assert done["event"] == "done"
    assert done["seconds"] >= 0
    assert done["at"].endswith("+00:00")


def test_a_stage_that_fails_says_why_on_one_line(monkeypatch, capsys):
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


def test_a_level_alone_gives_lines_of_text_from_that_level_on(monkeypatch, capsys):
    monkeypatch.setenv("MIMUCAL_LOG_LEVEL", "warning")
    set_up()
    unit = logging.getLogger("mimucal.station.unit")
    unit.info("opened")
    unit.warning("unit_lost_samples", extra={"of": "SN 7", "subject": "", "amount": 3})
    (line,) = capsys.readouterr().err.splitlines()
    at, _, event = line.partition(" ")
    assert at.endswith("+00:00")
    assert event == "WARNING station.unit: unit_lost_samples of=SN 7 amount=3"


def test_a_command_to_a_device_is_an_event_of_debug(monkeypatch, capsys):
    class Still:
        async def home(self) -> None: ...

        async def state(self) -> None: ...

    async def used(devices: Bus) -> None:
        table = OnBus("table", Still(), devices, StopSwitch())
        await table.state()
        await table.home()

    monkeypatch.setenv("MIMUCAL_LOG", "json")
    monkeypatch.setenv("MIMUCAL_LOG_LEVEL", "debug")
    set_up()
    with bus() as devices:
        asyncio.run(used(devices))
    (event,) = map(json.loads, capsys.readouterr().err.splitlines())
    assert (event["level"], event["logger"], event["event"]) == ("debug", "station.table", "home")


def test_a_service_whose_operator_sets_nothing_writes_errors(capsys):
    set_up(errors_at_least=True)
    logging.getLogger("mimucal.pages").warning("somebody waits")
    logging.getLogger("mimucal.pages").error("a callback failed")
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("ERROR pages: a callback failed")


def test_without_a_variable_nothing_is_written(capsys):
    set_up()
    logger_of("remind").error("failed")
    assert capsys.readouterr().err == ""


def test_another_value_is_one_sentence(mimucal, monkeypatch):
    monkeypatch.setenv("MIMUCAL_LOG", "xml")
    done = mimucal("runs")
    assert done.code == 2
    assert "MIMUCAL_LOG is 'xml'" in done.err
