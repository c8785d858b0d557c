"""The status of a run: whole whenever it is read, and a dead process is seen as dead."""

import signal
import subprocess
import sys
from datetime import UTC, datetime, timedelta

import pytest

from schemas.base import Unusable
from schemas.recording import RunStatus
from storage.home import Home
from storage.stations import end_dead_statuses, one_run_on, share_status, statuses, write_status

NOW = datetime(2026, 3, 1, tzinfo=UTC)


def status(state: str, station: str = "T1") -> RunStatus:
    return RunStatus.model_validate(
        {"station": station, "procedure": "jjf2003", "process": 1, "began_at": NOW, "at": NOW,
         "state": state, "now": "x", "segment": 1, "segments": 2, "station_s_done": 1.0,
         "station_s_total": 2.0, "wall_s_left": 1.0}
    )  # fmt: skip


def test_a_run_is_seen_as_dead_once_its_lock_is_free(tmp_path):
    home = Home(tmp_path)
    with one_run_on("T1", home):
        write_status(status("measuring"), home)
        assert statuses(home) == [(status("measuring"), False)]
    assert statuses(home) == [(status("measuring"), True)]


def test_each_station_has_one_and_what_is_not_understood_is_left_out(tmp_path):
    home = Home(tmp_path)
    for station in ("T1", "T2", "T2"):
        write_status(status("done", station), home)
    (home.status / "other.json").write_text("{", encoding="utf-8")
    assert sorted(each.station for each, _ in statuses(home)) == ["T1", "T2"]


def test_a_disk_that_refuses_costs_the_status_and_not_the_run(tmp_path):
    (tmp_path / "status").write_text("a file in the folder's place", encoding="utf-8")
    write_status(status("measuring"), Home(tmp_path))
    assert statuses(Home(tmp_path)) == []


def test_stations_of_another_computer_live_as_long_as_their_status_is_renewed(
    tmp_path, monkeypatch
):
    monkeypatch.setenv("MIMUCAL_STATION", str(tmp_path / "side"))
    home = Home(tmp_path / "home")
    home.path.mkdir()
    write_status(status("measuring").model_copy(update={"lock": "there:/side"}), home)
    share_status("T1", home)
    monkeypatch.delenv("MIMUCAL_STATION")
    ((shared, is_dead),) = statuses(home)
    assert (shared.state, is_dead) == ("measuring", False)
    monkeypatch.setattr("storage.stations.SILENCE", timedelta(0))
    assert statuses(home) == [(shared, True)]


def test_two_homes_of_one_station_side_exclude_each_other(tmp_path, monkeypatch):
    monkeypatch.setenv("MIMUCAL_STATION", str(tmp_path / "side"))
    with one_run_on("T1", Home(tmp_path / "a")):
        refused = pytest.raises(Unusable, match="station stop")
        with refused, one_run_on("T1", Home(tmp_path / "b")):
            pass


def test_the_status_of_a_dead_run_is_brought_to_the_truth(tmp_path):
    home = Home(tmp_path)
    write_status(status("measuring"), home)
    end_dead_statuses(home)
    ((ended, is_dead),) = statuses(home)
    assert (ended.state, is_dead) == ("stopped", False)


# One run on one station: a second is refused, and a dead one holds nothing.

HOLDER = (
    "import sys\n"
    "from pathlib import Path\n"
    "from storage.home import Home\n"
    "from storage.stations import one_run_on\n"
    "with one_run_on('T1', Home(Path(sys.argv[1]))):\n"
    "    print('held', flush=True)\n"
    "    sys.stdin.read()\n"
)


def test_a_second_run_is_refused_until_the_first_has_ended_even_by_kill(tmp_path):
    home = Home(tmp_path)
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as holder:  # fmt: skip
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        refused = pytest.raises(Unusable, match=rf"station T1 \(process {holder.pid}\)")
        with refused, one_run_on("T1", home):
            pass
        holder.send_signal(signal.SIGKILL)
        holder.wait()
    with one_run_on("T1", home):
        pass


def test_stations_side_by_side_do_not_wait_for_each_other(tmp_path):
    with one_run_on("T1", Home(tmp_path)), one_run_on("T2", Home(tmp_path)):
        assert len(list((tmp_path / "locks").iterdir())) == 2
