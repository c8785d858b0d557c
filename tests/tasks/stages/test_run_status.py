"""The status that a run keeps while it is acquired."""

from pathlib import Path

import pytest

from storage.home import Home
from storage.station_lock import statuses
from tasks.stages.acquire import status_file
from tasks.station import procedures
from tasks.station.progress import Progress
from tasks.station.virtual.config import VirtualStation, station_file

STATION = station_file(VirtualStation(), 1.0, "nowhere", 1, 2)
PROCEDURE = procedures.load("jjf2003")
TURNING = Progress("rate x", 10.0, 20.0, 5.0, "measuring", 3, 4, {"imu": 100.0}, {"gyro": 0.1})


def test_it_stands_as_the_run_and_then_as_its_end(tmp_path: Path) -> None:
    home, reported = Home(tmp_path), []
    with status_file(STATION, PROCEDURE, home, reported.append) as report:
        assert statuses(home)[0][0].state == "begun"
        report(TURNING)
        ((status, _),) = statuses(home)
    assert reported == [TURNING]
    assert (status.state, status.now, status.segment) == ("measuring", "rate x", 3)
    assert (status.rates_hz, status.noise) == ({"imu": 100.0}, {"gyro": 0.1})
    assert status.began_at <= status.at
    assert statuses(home)[0][0].state == "done"


def test_a_run_is_not_done_before_its_recording_is_in_the_store(tmp_path: Path) -> None:
    home = Home(tmp_path)
    with status_file(STATION, PROCEDURE, home, lambda _: None) as report:
        report(Progress("done", 20.0, 20.0, 0.0, "done", 4, 4))
        assert statuses(home)[0][0].state == "finishing"


def test_what_ends_a_run_is_its_cause(tmp_path: Path) -> None:
    home = Home(tmp_path)
    with (
        pytest.raises(KeyboardInterrupt),
        status_file(STATION, PROCEDURE, home, lambda _: None),
    ):
        raise KeyboardInterrupt
    ((status, is_dead),) = statuses(home)
    assert (status.state, status.cause, is_dead) == ("stopped", "KeyboardInterrupt", False)
