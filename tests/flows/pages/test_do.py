"""Orders given on the pages: by role, by the rules of the command line, and in the trail."""

import subprocess
import time
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from flows.pages.do import FIELDS, DoQuestion, Orders, answer, chosen, data, layout, step_answer
from flows.pages.parts import View, said, seen_by
from schemas.access import MAY, ROLES, Action, Role, Visitor
from schemas.base import Unusable
from storage.catalogue import audit_trail, orders
from storage.home import Home
from storage.stations import one_run_on, write_status
from tests.drafts import UNDECIDED, draft
from tests.flows.order_homes import CLIENT, add_station, no_workers
from tests.flows.pages.laid_out import components
from tests.flows.pages.test_line import ordered, status

EVENING = datetime(2026, 11, 27, 17, 30, tzinfo=UTC)  # half past one of the next day in Shanghai
STATED: dict[Role, set[Action]] = {
    "viewer": set(),
    "operator": {"acquire", "reprocess", "certify", "amend", "stop"},
    "verifier": {"check"},
    "issuer": {"issue", "withdraw"},
    "administrator": set(MAY),
}


class Started:
    """In the place of a process: what was started, and how it ended."""

    commands: list[tuple[list[str], dict[str, str]]]
    code: int | None

    def __init__(self) -> None:
        self.commands, self.code = [], None

    def __call__(self, command: list[str], **options: Any) -> "Started":
        self.commands.append((command, options["env"]))
        options["stdout"].write(b"begun\nthe reason, as one sentence\n")
        return self

    def poll(self) -> int | None:
        return self.code


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> Started:
    made = Started()
    monkeypatch.setattr(subprocess, "Popen", made)
    return made


def test_each_role_may_do_what_is_stated_and_is_refused_all_else(tmp_path: Path) -> None:
    given = Orders(Home(tmp_path))
    for role, action in product(ROLES, MAY):
        visitor = Visitor(name="Wang", role=role)
        assert visitor.may(action) == (action in STATED[role])
        # An empty form: whoever may is asked for what is missing, everybody else for another role.
        if action == "stop":
            continue  # on the page Line
        asked = "may not do this" if action not in STATED[role] else ""
        if action == "reprocess" and not asked:
            continue  # an empty selection is every run
        with pytest.raises(Unusable) as refused:
            given.give(action, {}, visitor)
        assert ("may not do this" in str(refused.value)) == bool(asked)
    assert set(FIELDS) == set(MAY) - {"stop"}
    assert {entry.action.split()[0] for entry in audit_trail.entries(Home(tmp_path))} == {"refuse"}


def test_three_persons_take_a_draft_to_its_number_and_the_trail_names_them(tmp_path: Path) -> None:
    home = Home(tmp_path)
    key = draft(home, "1").certificate.number
    given, form = Orders(home), {"certificate": key, "reason": "read again"}
    with pytest.raises(Unusable, match="another person must check"):
        given.give("check", form, Visitor(name="Wang", role="administrator"))
    given.give("check", form | {"by": "Somebody else"}, Visitor(name="Zhao", role="verifier"))
    number = given.give("issue", form, Visitor(name="Chen", role="issuer"))
    assert number.startswith("LAB-")
    withdraw = {"certificate": number, "reason": "wrong table"}
    given.give("withdraw", withdraw, Visitor(name="Chen", role="issuer"))
    steps = [(entry.person, entry.action) for entry in audit_trail.entries(home)]
    assert [step for step in steps if step[1] in ("check", "issue", "withdraw")] == [
        ("Zhao", "check"), ("Chen", "issue"), ("Chen", "withdraw")
    ]  # fmt: skip
    assert ("Chen", "sign withdraw") in steps


def test_long_work_is_a_process_of_the_command_line_with_an_entry_in_the_trail(
    tmp_path: Path, started: Started
) -> None:
    home = Home(tmp_path)
    draft(home, "1")
    given, operator = Orders(home), Visitor(name="Li", role="operator")
    run = given.give("certify", {"run": "run of 1"}, operator)
    given.give("reprocess", {"station": "T1", "out": "/etc", "since": "2026-01-01"}, operator)
    (first, environment), (second, _) = started.commands
    assert first[-3:] == ["certify", "--json", run]
    assert second[-4:] == ["reprocess", "--json", "--since=2026-01-01", "--station=T1"]
    assert (environment["MIMUCAL_USER"], environment["MIMUCAL_HOME"]) == ("Li", str(tmp_path))
    assert [entry.action for entry in audit_trail.entries(home)][-2:] == [
        "order certify", "order reprocess",
    ]  # fmt: skip
    assert {each.state for each in given.given()} == {"running"}
    started.code = 2
    assert {each.fault for each in given.given()} == {"the reason, as one sentence"}


@pytest.mark.parametrize(
    ("action", "fields"),
    [
        ("acquire", {"station": "../../etc/passwd", "serial": "S1"}),
        ("acquire", {"station": "LINE-1"}),
        ("acquire", {"station": "LINE-1", "serial": "S1", "procedure": "/etc/own.toml"}),
        ("acquire", {"station": "LINE-1", "serial": "S1", "client_order": "../own.toml"}),
        ("amend", {"certificate": "/etc", "reason": "why"}),
        ("certify", {"run": "/etc"}),
        ("certify", {"run": "--help"}),
        ("certify", {"run": "run of 1", "client_order": "../own.toml"}),
        ("certify", {"run": "run of 1", "tolerance": "../own.toml"}),
        ("reprocess", {"since": "not a day"}),
    ],
)
def test_nothing_is_started_of_what_is_not_the_homes_own(
    action: Action, fields: dict[str, str], tmp_path: Path, started: Started
) -> None:
    add_station(tmp_path)
    draft(Home(tmp_path), "1")
    (tmp_path / "own.toml").write_text(CLIENT, encoding="utf-8")
    with pytest.raises(Unusable):
        Orders(Home(tmp_path)).give(action, fields, Visitor(name="Li", role="operator"))
    assert started.commands == []


def test_a_draft_is_ordered_with_whose_it_is_who_measured_and_whether_it_is_a_report(
    tmp_path: Path, started: Started
) -> None:
    home, folder = Home(tmp_path), tmp_path / "client-orders"
    draft(home, "1")
    folder.mkdir()
    (folder / "acme.toml").write_text(CLIENT, encoding="utf-8")
    form = {"run": "run of 1", "client_order": "acme.toml", "operator": "Li Na", "report": "§ 4"}
    run = Orders(home).give("certify", form, Visitor(name="Li", role="operator"))
    ((command, _),) = started.commands
    assert command[-4:] == [
        run, f"--order={folder / 'acme.toml'}", "--operator=Li Na", "--report=§ 4"
    ]  # fmt: skip


def test_a_form_for_each_order_that_the_role_allows(tmp_path: Path) -> None:
    home = Home(tmp_path)
    draft(home, "1")
    shown = data(DoQuestion(), home)
    assert [each.state for each in shown.certificates] == ["draft"]
    refused = seen_by(View(visitor=Visitor(name="Li", role="operator")), answer, "issue", {}, home)
    assert "“Issue a certificate”; these do: issuer, administrator" in str(refused)


def test_a_run_is_ordered_with_its_unit_and_waits_in_the_queue_of_its_station(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home, begun = Home(tmp_path), no_workers(monkeypatch)
    add_station(tmp_path)
    (tmp_path / "client-orders").mkdir()
    (tmp_path / "client-orders" / "acme.toml").write_text(CLIENT, encoding="utf-8")
    operator = View(visitor=Visitor(name="Li", role="operator"))
    form = {"station": "LINE-1", "serial": " S1 ", "model": "M3", "client_order": "acme.toml"}
    assert "S1" in str(seen_by(operator, answer, "acquire", form, home))
    shown = data(DoQuestion(), home)
    assert (shown.stations, shown.client_orders) == (("LINE-1",), ("acme.toml",))
    (order,) = shown.production
    assert (order.person, order.serials, order.units[0].model) == ("Li", "S1", "M3")
    assert order.client_order is not None
    assert begun.commands[0][-3:] == ["station", "work", "LINE-1"]
    assert "Cancel" in str(seen_by(operator, layout, shown, DoQuestion()))
    viewer = View(visitor=Visitor(name="Wu", role="viewer"))
    assert "Cancel" not in str(seen_by(viewer, layout, shown, DoQuestion()))
    button = {"step": "cancel", "number": order.number}
    assert "Your role does not allow" in str(seen_by(viewer, step_answer, button, home))
    seen_by(operator, step_answer, button, home)
    assert [each.state for each in data(DoQuestion(), home).production] == ["cancelled"]
    seen_by(operator, step_answer, {"step": "retry", "number": order.number}, home)
    assert [each.state for each in data(DoQuestion(), home).production] == ["waiting"]


def test_a_card_has_a_title_and_what_the_chosen_certificate_says_beside_its_button(
    tmp_path: Path,
) -> None:
    home = Home(tmp_path)
    number = draft(home, "1", decision=UNDECIDED).certificate.number
    view = View(visitor=Visitor(name="Chen", role="administrator"))
    shown = seen_by(view, layout, data(DoQuestion(), home), DoQuestion())
    titles = [part.children for part in of_kind(shown, "Title") if part.order == 4]
    assert titles == [seen_by(view, said, f"pages-action.{action}") for action in FIELDS]
    (waits,) = of_kind(seen_by(view, chosen, "check", None, home), "Button")
    assert waits.disabled
    shown = seen_by(view, chosen, "check", number, home)
    for part in ("Maker U 1", "Client", "Wang, 2026-11-21", "1 pass, 0 fail",
                 "no limits are defined", f"/certificate/{number}.pdf"):  # fmt: skip
        assert part.lower() in str(shown).lower()
    assert "data-ask" not in str(shown)
    (withdraws,) = of_kind(seen_by(view, chosen, "withdraw", number, home), "Button")
    assert f"Withdraw certificate {number}?" in getattr(withdraws, "data-ask")


def test_the_queue_says_how_far_an_order_is_and_local_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home, operator = Home(tmp_path), View(visitor=Visitor(name="Li", role="operator"))
    orders.add([ordered("A-1").model_copy(update={"ordered_at": EVENING})], home)
    orders.claim("A-1", home)
    write_status(status(), home)
    monkeypatch.setenv("TZ", "Asia/Shanghai")
    time.tzset()
    try:
        with one_run_on("T1", home):
            found = data(DoQuestion(), home)
        shown = seen_by(operator, layout, found, DoQuestion())
    finally:
        monkeypatch.undo()
        time.tzset()
    assert "2026-11-28 01:30:00" in str(shown)
    assert [bar.value for bar in of_kind(shown, "Progress")] == [25.0]
    assert "data-busy" in str(shown)


def of_kind(shown: Any, kind: str) -> list[Any]:
    return [each for each in components(shown) if type(each).__name__ == kind]


def test_an_issued_certificate_is_amended_by_limits_of_the_home(
    tmp_path: Path, started: Started
) -> None:
    home = Home(tmp_path)
    number = draft(home, "1").certificate.number
    (tmp_path / "tolerances").mkdir(exist_ok=True)
    (tmp_path / "tolerances" / "new.toml").write_text("", encoding="utf-8")
    given, operator = Orders(home), Visitor(name="Li", role="operator")
    form = {"certificate": number, "reason": "--by", "tolerance": "new.toml"}
    given.give("amend", form, operator)
    (command, environment) = started.commands[-1]
    limits = f"--tolerance={tmp_path / 'tolerances' / 'new.toml'}"
    assert command[-5:] == ["amend", "--json", number, "--why=--by", limits]
    assert environment["MIMUCAL_USER"] == "Li"
    with pytest.raises(Unusable, match=r"there is no file '\.\./own.toml'"):
        given.give("amend", form | {"tolerance": "../own.toml"}, operator)
