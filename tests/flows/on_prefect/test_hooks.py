"""What Prefect's hooks do with a station whose run crashed."""

from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from flows.on_prefect.hooks import free_station
from schemas.run_log import RunStatus
from storage.home import Home
from storage.station_lock import one_run_on, write_status
from tasks.station.virtual import config


@pytest.fixture
def station_file(tmp_path: Path) -> Path:
    file = tmp_path / "station.json"
    station = config.virtual_station(1, False).model_copy(update={"id": "LAB-1"})
    made = config.station_file(station, 1.0, "127.0.0.1", 5020, 5021)
    file.write_text(made.model_dump_json(), encoding="utf-8")
    return file


@pytest.fixture
def stopped(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, str]]:
    calls: list[tuple[str, str]] = []
    monkeypatch.setattr(
        "flows.on_prefect.hooks.stop_station",
        lambda id_, by, _, **lockout: calls.append((id_, by)),
    )
    return calls


def crash(home: Home, file: Path) -> None:
    run: Any = SimpleNamespace(parameters={"order": {"station": str(file), "home": str(home.path)}})
    state: Any = SimpleNamespace(name="Crashed", message="its worker is gone")
    free_station(SimpleNamespace(name="produce"), run, state)


@pytest.fixture
def left(tmp_path: Path, station_file: Path) -> Home:
    """A home in which a run of the station began, and has not said how it ended."""
    home, now = Home(tmp_path / "home"), datetime.now(UTC)
    write_status(
        RunStatus(
            station="LAB-1", procedure="jjf2003", process=1, began_at=now, at=now,
            state="measuring", now="rate", segment=3, segments=9, station_s_done=1.0,
            station_s_total=2.0, wall_s_left=1.0,
        ),
        home,
    )  # fmt: skip
    return home


def test_a_crash_stops_the_table_of_a_run_whose_process_is_dead(
    left: Home, station_file: Path, stopped: list[tuple[str, str]]
) -> None:
    crash(left, station_file)
    assert stopped == [("LAB-1", "Prefect (Crashed: its worker is gone)")]


def test_a_crash_leaves_another_run_of_the_station_alone(
    left: Home, station_file: Path, stopped: list[tuple[str, str]]
) -> None:
    with one_run_on("LAB-1", left):
        crash(left, station_file)
    assert stopped == []


def test_a_crash_of_an_order_whose_station_is_not_known_does_nothing(
    left: Home, stopped: list[tuple[str, str]]
) -> None:
    crash(left, Path("nowhere.json"))
    assert stopped == []
