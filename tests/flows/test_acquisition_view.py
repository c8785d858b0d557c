"""What is shown of an acquisition, on a terminal and elsewhere."""

import pytest
from rich.console import Console

from flows import acquisition_view
from schemas.run_log import Alarm
from tasks.station.progress import Progress

ALARM = Alarm(en="lost samples from the unit (2×)", zh="被校对象丢失采样（2 次）")
TURNING = Progress(
    "rate x +100 deg/s", 120.0, 3000.0, 48.0, "measuring", 13, 48,
    {"imu": 100.0, "table": 100.02}, {"gyro": 0.0123, "accel": 0.0021}, (ALARM,),
)  # fmt: skip
SHOWN = (
    "measuring: rate x +100 deg/s", "13 of 48", "120 of 3000 s station time, 48 s left",
    "imu 100.0 Hz, table 100.0 Hz", "gyro 0.012 °/s, accel 0.0021 m/s²", ALARM.en,
)  # fmt: skip


def test_a_terminal_shows_state_segment_time_rates_noise_and_alarms() -> None:
    console = Console(width=100)
    with console.capture() as captured:
        console.print(acquisition_view.view(TURNING))
    printed = captured.get()
    assert [text for text in SHOWN if text not in printed] == []


def test_elsewhere_a_line_comes_now_and_then(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter((0.0, 10.0, 30.0, 30.0, 59.0))
    monkeypatch.setattr(acquisition_view.time, "monotonic", lambda: next(clock))
    show = acquisition_view.plain_lines()
    for _ in range(3):
        show(TURNING)
    (line,) = capsys.readouterr().err.splitlines()
    assert [text for text in SHOWN if text not in line] == []


def test_station_status_says_how_each_run_stands(mimucal, home) -> None:
    from storage.home import Home
    from tests.storage.test_stations import status, write_status

    write_status(status("measuring"), Home(home))
    (run,) = mimucal("station", "status", "--json").json["runs"]
    assert (run["station"], run["state"], run["is_dead"]) == ("T1", "stopped", False)
    printed = mimucal("station", "status").out
    assert "stopped: x; 1 of 2" in printed
    assert "ended without a word" in printed
