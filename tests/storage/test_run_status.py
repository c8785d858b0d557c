"""The status of a run: whole whenever it is read, and a dead process is seen as dead."""

from datetime import UTC, datetime
from pathlib import Path

from schemas.run_log import RunStatus
from storage.home import Home
from storage.station_lock import one_run_on, statuses, write_status

NOW = datetime(2026, 3, 1, tzinfo=UTC)


def status(state: str, station: str = "T1") -> RunStatus:
    return RunStatus.model_validate(
        {"station": station, "procedure": "jjf2003", "process": 1, "began_at": NOW, "at": NOW,
         "state": state, "now": "x", "segment": 1, "segments": 2, "station_s_done": 1.0,
         "station_s_total": 2.0, "wall_s_left": 1.0}
    )  # fmt: skip


def test_a_run_is_seen_as_dead_once_its_lock_is_free(tmp_path: Path) -> None:
    home = Home(tmp_path)
    with one_run_on("T1", home):
        write_status(status("measuring"), home)
        assert statuses(home) == [(status("measuring"), False)]
    assert statuses(home) == [(status("measuring"), True)]


def test_a_run_that_ended_with_a_word_is_not_dead(tmp_path: Path) -> None:
    home = Home(tmp_path)
    for state in ("stopped", "done"):
        write_status(status(state), home)
        assert statuses(home) == [(status(state), False)]


def test_each_station_has_one_and_what_is_not_understood_is_left_out(tmp_path: Path) -> None:
    home = Home(tmp_path)
    for station in ("T1", "T2", "T2"):
        write_status(status("done", station), home)
    (home.status / "other.json").write_text("{", encoding="utf-8")
    assert sorted(each.station for each, _ in statuses(home)) == ["T1", "T2"]


def test_looking_does_not_keep_a_run_from_its_station(tmp_path: Path) -> None:
    home = Home(tmp_path)
    write_status(status("measuring"), home)
    for _ in range(100):
        statuses(home)
        with one_run_on("T1", home):
            pass


def test_a_disk_that_refuses_costs_the_status_and_not_the_run(tmp_path: Path) -> None:
    (tmp_path / "status").write_text("a file in the folder's place", encoding="utf-8")
    write_status(status("measuring"), Home(tmp_path))
    assert statuses(Home(tmp_path)) == []
