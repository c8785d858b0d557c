"""A stop of a station: by its run's process, or directly, whatever else is away."""

import asyncio
import os
import pwd
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import pytest

from schemas.base import BrokenOff, Unusable
from schemas.procedure import Procedure
from schemas.station import StationFile
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from storage.stations import is_held, keep_station_file, one_run_on, request_in, statuses
from tasks.stages.acquire import acquire_run
from tasks.stages.stop import current_user, stop_station
from tasks.station import procedures
from tasks.station.connected_station import StopSwitch, run_until_stopped
from tasks.station.virtual.config import VirtualStation
from tests.tasks.station.over_sockets import serving, table_and_watchdog

pytestmark = pytest.mark.real_time
SPEED = 10.0


@pytest.fixture(scope="module")
def station() -> Iterator[StationFile]:
    with serving(VirtualStation(), SPEED) as found:
        yield found


@pytest.fixture
def home(tmp_path, monkeypatch) -> Home:
    """One on the network, in effect: the station has a folder of its own."""
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    monkeypatch.setenv("MIMUCAL_STATION", str(tmp_path / "side"))
    home = Home(tmp_path / "home")
    home.path.mkdir()
    home.station_side.mkdir()
    return home


@pytest.fixture
def turning() -> Procedure:
    """It turns the table at once, and for longer than any test."""
    whole = procedures.load("jjf2003")
    run = next(step for step in whole.steps if step.kind == "rate_run")
    longer = run.model_copy(update={"dwell_s": 3600.0})
    return whole.model_copy(update={"steps": (longer,), "warm_up_s": 1.0})


@pytest.fixture
def acquiring(station, home, turning) -> Iterator[Callable[..., "Future[object]"]]:
    """Begins a run in a thread, and waits until its table turns."""
    switch = StopSwitch()
    with ThreadPoolExecutor(1) as pool:

        def begin(report: Callable[[object], None] = lambda progress: None) -> "Future[object]":
            began = threading.Event()

            def seen(progress: object) -> None:
                if str(getattr(progress, "now", "")).startswith("rate"):
                    began.set()
                report(progress)

            run = pool.submit(acquire_run, station, turning, home, seen, stop=switch)
            assert began.wait(60), run
            return run

        yield begin
        switch.press("the test")


def at_rest(station: StationFile) -> bool:
    state, watchdog = table_and_watchdog(station)
    return watchdog == 0 and not any(axis.is_moving for axis in state.axes)


def test_whoever_stops_has_a_name_even_in_a_container_whose_user_has_none(monkeypatch):
    for name in ("MIMUCAL_USER", "LOGNAME", "USER", "LNAME", "USERNAME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(pwd, "getpwuid", {}.__getitem__)
    assert current_user() == f"uid {os.geteuid()}"


def test_the_run_stops_the_table_keeps_its_recording_and_says_who(station, home, acquiring):
    run = acquiring()
    stopped = stop_station(station.station.id, "Li", home)
    assert (stopped.at_rest, stopped.way, stopped.by) == (True, "run", "Li")
    assert [axis.name for axis in stopped.axes] == ["outer", "middle", "inner"]
    with pytest.raises(BrokenOff, match="stopped by Li; recorded so far"):
        run.result(30)
    assert at_rest(station)
    (left,) = stopped.recordings
    log = read_mcap(Path(left), salvage=True).manifest.model_extra["log"]
    assert log[-1]["en"] == "Run stopped by Li."
    for folder in (home, Home(home.station_side)):
        ((status, is_dead),) = statuses(folder)
        assert (status.state, is_dead) == ("stopped", False)
        assert status.cause.startswith("stopped by Li")
    assert not is_held(station.station.id, home)
    assert request_in(home.locks, station.station.id) is None


def test_a_run_whose_loop_hangs_is_stopped_all_the_same(station, home, acquiring):
    hangs, released = threading.Event(), threading.Event()

    def hang(progress: object) -> None:
        if str(getattr(progress, "now", "")).startswith("rate"):
            hangs.set()
            released.wait(60)

    run = acquiring(hang)
    assert hangs.wait(30)
    try:
        stopped = stop_station(station.station.id, "Li", home)
        assert (stopped.at_rest, stopped.way) == (True, "run")
        assert statuses(home)[0][0].state == "stopped"
    finally:
        released.set()
    with pytest.raises(BrokenOff, match="stopped by Li"):
        run.result(30)


def test_it_works_while_the_home_is_away(station, home, acquiring):
    run = acquiring()
    home.path.rename(home.path.with_name("away"))
    stopped = stop_station(station.station.id, "Li", home)
    assert stopped.at_rest
    assert Path(stopped.recordings[0]).is_file()
    with pytest.raises(BrokenOff, match="stopped by Li"):
        run.result(30)
    assert not home.path.exists()  # nothing is made where a disk is away


@pytest.mark.rehearsal
def test_another_computer_asks_by_way_of_the_home(station, home, acquiring, monkeypatch):
    run = acquiring()
    time.sleep(1.5)  # its status is in the home by now
    monkeypatch.delenv("MIMUCAL_STATION")
    keep_station_file(station, home)
    stopped = stop_station(station.station.id, "Li", home)
    assert stopped.at_rest
    with pytest.raises(BrokenOff, match="stopped by Li"):
        run.result(30)


@pytest.mark.rehearsal
def test_a_second_press_does_not_break_the_stop_off(station, home, acquiring):
    run = acquiring()
    with ThreadPoolExecutor(2) as pool:
        both = pool.map(lambda by: stop_station(station.station.id, by, home), ("Li", "Wang"))
        assert all(stopped.at_rest for stopped in both)
    with pytest.raises(BrokenOff, match="stopped by"):
        run.result(30)
    assert at_rest(station)


def test_where_no_process_runs_the_table_is_stopped_directly(station, home):
    keep_station_file(station, home)
    stopped = stop_station(station.station.id, "Li", home)
    assert (stopped.at_rest, stopped.way) == (True, "directly")


def test_a_process_that_holds_the_station_and_is_silent_is_not_waited_for(station, home):
    keep_station_file(station, home)
    with one_run_on(station.station.id, home):
        stopped = stop_station(station.station.id, "Li", home)
    assert (stopped.at_rest, stopped.way) == (True, "directly")


def test_a_table_that_does_not_answer_is_not_called_at_rest(station, home):
    table = station.table.model_copy(update={"url": "socket://127.0.0.1:1"})
    keep_station_file(station.model_copy(update={"table": table}), home)
    stopped = stop_station(station.station.id, "Li", home)
    assert not stopped.at_rest
    assert "does not answer" in stopped.fault


def test_a_station_that_nobody_knows_is_refused(home):
    with pytest.raises(Unusable, match="has no file of station T9"):
        stop_station("T9", "Li", home)


def test_a_request_of_an_earlier_time_does_not_end_a_new_run(station, home, acquiring):
    keep_station_file(station, home)
    stop_station(station.station.id, "Li", home)
    run = acquiring()
    time.sleep(0.5)
    assert not run.done()


def test_the_switch_ends_work_once_however_often_it_is_pressed():
    switch, ended = StopSwitch(), []

    async def work() -> None:
        try:
            await asyncio.sleep(60)
        finally:
            switch.press("a second")
            await asyncio.sleep(0.05)  # how it ends takes a while
            ended.append(switch.by)

    threading.Timer(0.1, switch.press, ["a first"]).start()
    with pytest.raises(Exception, match="a first"):
        run_until_stopped(work(), switch)
    assert ended == ["a first"]
