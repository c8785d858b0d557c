"""The page of what is due: as the reminders have it, by client, model and time."""

import shutil
from datetime import UTC, date, datetime, timedelta
from pathlib import Path

import pytest

from flows.pages.due import DueQuestion, DueShown, data, due_state
from schemas.base import Unusable
from storage.catalogue import certificates, equipment
from storage.home import Home
from tasks.reminders import pause
from tasks.stages.remind import due_units
from tests.proof.line import Line

NOW = datetime(2026, 1, 10, tzinfo=UTC)


@pytest.fixture(scope="module")
def home(line_store: tuple[Home, Line], tmp_path_factory: pytest.TempPathFactory) -> Home:
    """The line of two units of two clients; one was reminded, and a message to the other failed."""
    copy = Home(tmp_path_factory.mktemp("due") / "home")
    shutil.copytree(line_store[0].path, copy.path)
    for number, fault in enumerate((None, "no such mailbox")):
        key = (due_units(copy)[number].certificate, -30, f"client {number} mail")
        assert equipment.claim(copy, key, NOW, pause)
        equipment.note(copy, key, NOW, fault)
    return copy


@pytest.fixture(autouse=True)
def at_a_day_between_the_two(home: Home, monkeypatch: pytest.MonkeyPatch) -> date:
    """One unit is overdue by a day and the other is due later."""
    day = due_units(home)[0].due + timedelta(days=1)
    monkeypatch.setitem(data.__globals__, "today", lambda: day)
    return day


def asked(home: Home, **fields: object) -> DueShown:
    return data(DueQuestion.model_validate(fields), home)


def test_units_are_those_that_the_reminders_name(home: Home) -> None:
    every = asked(home, within=36_500)
    assert [(u.name, u.certificate, u.due, u.client) for u in every.units] == [
        (r.unit, r.certificate, r.due, r.client) for r in due_units(home)
    ]
    first, second = every.units
    assert (first.days, first.messages, second.messages) == (-1, 1, 0)
    assert second.days > 0
    overdue = asked(home, within=0)
    assert [u.name for u in overdue.units] == [first.name]
    assert [(c.overdue, c.coming) for c in overdue.by_client] == [(1, 0)]
    just = asked(home, within=second.days)
    assert len(just.units) == 2
    assert len(asked(home, within=second.days - 1).units) == 1
    of_record = certificates.find(second.certificate, home)
    assert second.client[0] == of_record.order.client.name


def test_a_client_and_a_model_see_their_own_alone(home: Home) -> None:
    first, second = asked(home, within=36_500).units
    one = asked(home, within=36_500, client=second.client[0])
    assert [u.name for u in one.units] == [second.name]
    assert [m.certificate for m in one.messages] == [second.certificate]
    assert len(one.clients) == 2
    assert [u.name for u in asked(home, within=36_500, model=first.model).units] == [first.name]
    assert asked(home, client="nobody").units == ()
    assert sum(m.units for m in one.months) <= 1


def test_equipment_has_the_certificate_that_counts(home: Home) -> None:
    shown = asked(home)
    counting = equipment.on_day(home, shown.today)
    assert {e.serial: e.certificate for e in shown.equipment} == {
        serial: standard.certificate for serial, standard in counting.items()
    }
    days = [e.days for e in shown.equipment]
    assert days == sorted(days)


def test_a_state_is_bad_from_the_day_after_and_open_for_ninety_days_before() -> None:
    day = date(2026, 3, 1)
    kinds = [due_state(day + timedelta(days=n), day).kind for n in (-1, 0, 90, 91)]
    assert kinds == ["bad", "open", "open", "good"]
    assert due_state(None, day).kind == "none"


def test_a_certificate_that_was_damaged_is_named(home: Home, tmp_path: Path) -> None:
    broken = Home(tmp_path / "home")
    shutil.copytree(home.path, broken.path)
    number = due_units(broken)[0].certificate
    (broken.certificates / f"{number}.json").write_text("{", encoding="utf-8")
    with pytest.raises(Unusable, match=f"{number}.json"):
        asked(broken)
