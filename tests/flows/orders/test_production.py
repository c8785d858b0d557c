"""Orders carried out: each once, the next whatever becomes of one, and on where a process died."""

import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from flows.orders import production
from flows.orders.production import (
    Production,
    cancel,
    carry_out,
    give,
    requeue_orphans,
    retry,
    submit,
    work_at,
)
from schemas.base import BrokenOff, Unusable
from schemas.orders import OrderRequest, ProduceOrder, ProductionOrder
from schemas.recording import Unit
from storage.catalogue import audit_trail, orders
from storage.home import Home
from storage.stations import one_order_at, one_run_on, only_worker_of
from tasks.words import message
from tests.flows.order_homes import add_station, no_workers

POPEN = subprocess.Popen  # before it is replaced
HOLD = """
import sys, time
from flows.orders.production import carry_out
from schemas.orders import ProduceOrder
def work(production):
    print("begun", flush=True)
    time.sleep(600)
carry_out(ProduceOrder(station="LINE-1", number="1"), work)
"""


@pytest.fixture
def line(home, monkeypatch) -> Home:
    """A home with a station and three orders for it, which nobody takes yet."""
    with_orders(home, monkeypatch)
    return Home(home)


def with_orders(home: Path, patch: pytest.MonkeyPatch) -> None:
    add_station(home)
    add_station(home, "LINE-2")
    no_workers(patch)
    for number in "123":
        give(request(number), "Li", Home(home))


def request(number: str | None, serial: str | None = None) -> OrderRequest:
    unit = {"serial": serial or f"S{number}"}
    return OrderRequest.model_validate({"number": number, "station": "LINE-1", "units": [unit]})


class Work:
    """In the place of station and certificate: what was asked for, and what each ends with."""

    def __init__(self, **faults: BaseException) -> None:
        self.done: list[ProduceOrder] = []
        self.faults = faults

    def __call__(self, ordered: Production) -> tuple[Any, ...]:
        self.done.append(ordered.order)
        if fault := self.faults.get(ordered.kept.serials):
            raise fault
        return ()

    @property
    def serials(self) -> list[str]:
        return [unit.serial for order in self.done for unit in order.units]


@pytest.fixture
def worked(monkeypatch) -> Callable[[Work], Work]:
    def use(work: Work) -> Work:
        monkeypatch.setattr(production, "produce", lambda order: carry_out(order, work))
        return work

    return use


def ignore(_: ProductionOrder) -> None: ...


def states(home: Home) -> list[str]:
    return [each.state for each in orders.listed(home)]


def test_a_station_takes_its_orders_in_their_sequence_with_unit_and_person(line, worked):
    work, reported = worked(Work()), []
    assert work_at("LINE-1", line, reported.append)
    assert work.serials == ["S1", "S2", "S3"]
    assert {order.by for order in work.done} == {"Li"}
    assert states(line) == ["done"] * 3
    assert [each.state for each in reported] == ["done"] * 3
    assert work_at("LINE-1", line, ignore)
    assert len(work.done) == 3


def test_an_order_that_fails_says_why_and_keeps_no_other_from_being_taken(line, worked):
    worked(Work(S1=Unusable("mount S1, or order S9"), S2=BrokenOff("unit S2 was given up")))
    assert work_at("LINE-1", line, ignore)
    assert states(line) == ["failed", "failed", "done"]
    assert orders.find("1", line).fault == "mount S1, or order S9"


def test_after_an_operators_stop_nothing_begins_to_turn_by_itself(line, worked):
    stop = BrokenOff("stopped by the operator")
    stop.__cause__ = KeyboardInterrupt()
    work = worked(Work(S1=stop))
    with pytest.raises(BrokenOff, match="`mimucal order retry 1` goes on with it"):
        work_at("LINE-1", line, ignore)
    assert states(line) == ["failed", "waiting", "waiting"]
    assert work.serials == ["S1"]


def test_an_order_of_another_station_is_not_carried_out(line):
    work = Work()
    with pytest.raises(Unusable, match="order 1 is for station LINE-1, and this is LINE-2"):
        carry_out(ProduceOrder(station="LINE-2", number="1"), work)
    assert work.done == []
    assert states(line) == ["waiting"] * 3


def test_nothing_is_done_of_an_order_that_is_done_or_cancelled(line):
    work = Work()
    orders.cancel("2", "Li", line)
    for number in ("1", "1", "2"):
        carry_out(ProduceOrder(station="LINE-1", number=number), work)
    assert work.serials == ["S1"]
    assert states(line) == ["done", "cancelled", "waiting"]


def test_a_schedule_makes_an_order_of_its_own_for_the_unit_of_the_station_file(line):
    work = Work()
    for number in "123":
        orders.cancel(number, "Li", line)
    carry_out(ProduceOrder(station="LINE-1"), work)
    own = orders.listed(line)[-1]
    assert (own.person, own.serials, own.state) == ("schedule", "0001", "done")
    assert work.done[0].by is None


def test_an_order_whose_unit_is_mounted_does_not_wait_behind_one_whose_unit_is_not(
    line, worked, monkeypatch
):
    mounted = ["S2"]

    def confirm(unit: Unit, _: object) -> None:
        if unit.serial not in mounted:
            cause = message(production.OTHER_UNIT, found=mounted[0], ordered=unit.serial)
            raise Unusable(f"mount {unit.serial}", cause)

    monkeypatch.setattr(production, "confirm", confirm)
    work = worked(Work(S3=Unusable("it is broken")))
    orders_left = ["S2", "S3", "S1"]
    monkeypatch.setattr(
        production, "time",
        SimpleNamespace(sleep=lambda _: mounted.__setitem__(0, orders_left[len(work.done)])),
    )  # fmt: skip
    assert work_at("LINE-1", line, ignore)
    assert work.serials == ["S2", "S3", "S1"]
    assert states(line) == ["done", "done", "failed"]


def test_a_schedule_takes_the_queue(line):
    work = Work()
    carry_out(ProduceOrder(station="LINE-1"), work)
    assert work.serials == ["S1"]
    assert len(states(line)) == 3


def test_after_an_invalid_run_an_order_is_measured_again_under_its_number(
    line, worked, monkeypatch
):
    orders.claim("1", line)
    orders.note("1", line, runs=("r1",))
    orders.finish("1", "failed", line, "run r1 is invalid: the unit was touched")
    monkeypatch.setattr(orders, "_is_invalid", lambda runs, _: "r1" in runs)
    assert retry("1", "Li", line).order.runs == ()
    last = json.loads(audit_trail.entries(line)[-1].details)
    assert last == {"again": True, "reason": "run r1 is invalid: the unit was touched",
                    "runs": ["r1"]}  # fmt: skip
    orders.claim("1", line)
    orders.note("1", line, runs=("r2",))
    orders.finish("1", "failed", line, "no paper")
    assert retry("1", "Li", line, "paper is there").order.runs == ("r2",)  # is not repeated
    assert [orders.measured_for(each, line) for each in ("r1", "r2", "r3")] == [
        ("1", 1), ("1", 2), None,
    ]  # fmt: skip


def test_an_order_waits_for_a_run_that_was_begun_by_hand(line, monkeypatch):
    waited = []

    def end(_: float) -> None:
        waited.append(states(line)[0])
        held.__exit__(None, None, None)

    held = one_run_on("LINE-1", line)
    held.__enter__()
    monkeypatch.setattr(production, "time", SimpleNamespace(sleep=end))
    carry_out(ProduceOrder(station="LINE-1", number="1"), Work())
    assert waited == ["waiting"]
    assert states(line)[0] == "done"


def test_after_a_stop_the_next_order_waits_until_somebody_releases_the_station(
    line, monkeypatch, mimucal
):
    waited = []

    def see(_: float) -> None:
        waited.append(states(line)[0])
        assert "stopped by Li" in mimucal("station", "release", "LINE-1").out

    mimucal("station", "stop", "LINE-1", "--by", "Li")
    monkeypatch.setattr(production, "time", SimpleNamespace(sleep=see))
    carry_out(ProduceOrder(station="LINE-1", number="1"), Work())
    assert waited == ["waiting"]
    assert states(line)[0] == "done"
    assert "not locked out" in mimucal("station", "release", "LINE-1").out


def test_one_worker_takes_the_orders_of_a_station_and_another_leaves_them(line, worked):
    work = worked(Work())
    with only_worker_of("LINE-1", line):
        assert not work_at("LINE-1", line, ignore)
    assert work.done == []


@pytest.fixture(scope="module")
def left_in_the_middle(tmp_path_factory) -> Home:
    """A home whose process was killed in the middle of order 1."""
    home = Home(tmp_path_factory.mktemp("killed") / "home")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MIMUCAL_HOME", str(home.path))
        with_orders(home.path, patch)
        command = [sys.executable, "-c", HOLD]
        with POPEN(command, stdout=subprocess.PIPE, text=True, env=os.environ) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "begun\n"
            os.kill(process.pid, signal.SIGKILL)
    return home


@pytest.fixture
def killed(left_in_the_middle, home, monkeypatch) -> Home:
    """A copy of it."""
    no_workers(monkeypatch)
    shutil.copytree(left_in_the_middle.path, home)
    return Home(home)


@pytest.mark.real_time
def test_an_order_whose_process_was_killed_is_carried_out_by_the_next_one(killed, worked):
    assert states(killed)[0] == "running"
    work = worked(Work())
    assert work_at("LINE-1", killed, ignore)
    assert work.serials == ["S1", "S2", "S3"]
    assert not any(order.resume for order in work.done)  # it had recorded nothing
    first = orders.find("1", killed)
    assert (first.state, first.attempts) == ("done", 2)


@pytest.mark.real_time
@pytest.mark.parametrize("seen_by", ["submit", "retry", "another"])
def test_an_order_whose_process_died_is_seen_as_such_by_whoever_looks(killed, seen_by):
    with one_order_at("LINE-1", killed):
        assert requeue_orphans(killed) == []  # somebody has the orders of the station
    if seen_by == "submit":
        submit(killed)
    elif seen_by == "retry":
        assert retry("1", "Li", killed).order.state == "waiting"
    else:
        assert cancel("1", "Li", killed).state == "cancelled"
    assert states(killed)[1:] == ["waiting"] * 2
    assert orders.find("1", killed).is_interrupted


def test_an_order_whose_process_lives_is_left_to_it(line):
    orders.claim("1", line)
    assert requeue_orphans(line) == []
    assert states(line)[0] == "running"


def test_what_was_measured_is_not_measured_again_and_what_was_interrupted_goes_on(
    line, worked, monkeypatch
):
    orders.claim("1", line)
    orders.note("1", line, runs=("r1",))
    orders.claim("2", line)
    orders.claim("3", line)
    with one_order_at("LINE-1", line):
        orders.put_back("LINE-1", line)
    monkeypatch.setattr(production, "_is_left", lambda kept, *_: kept.number == "2")
    monkeypatch.setattr(
        orders, "stored_since", lambda kept, _: ("r3",) if kept.number == "3" else ()
    )
    seen = []

    def work(ordered: Production) -> tuple[Any, ...]:
        seen.append((ordered.kept.number, ordered.runs, ordered.order.resume))
        return ()

    worked(work)
    work_at("LINE-1", line, ignore)
    assert seen == [("1", ("r1",), False), ("2", (), True), ("3", ("r3",), False)]


def test_a_client_s_order_and_a_deployment_s_files_go_together(line):
    work = Work()
    order = ProduceOrder(station="LINE-1", number="1", laboratory="lab.toml", client_order="c.toml")
    carry_out(order, work)
    (done,) = work.done
    assert (done.laboratory, done.client_order) == ("lab.toml", "c.toml")
