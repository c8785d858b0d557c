"""The person at the terminal, on a terminal of its own."""

import asyncio
import os
import pty
import sys
from collections.abc import Iterator

import pytest
from rich.console import Console

from flows import acquisition_view, terminal
from flows.terminal import FRAMED, print_rows, remaining
from schemas.base import Unusable
from schemas.procedure import Procedure, Refix
from schemas.recording import Alarm
from tasks.explain.progress import BEHIND, report_progress
from tasks.station import procedures
from tasks.station.progress import Progress

WHOLE: Procedure = procedures.load("jjf1536")
REFIX = next(step for step in WHOLE.steps if isinstance(step, Refix))


@pytest.fixture
def keyboard(monkeypatch) -> Iterator[int]:
    """The other end of a terminal that is standard input."""
    keys, terminal = pty.openpty()
    with os.fdopen(terminal) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        yield keys
    os.close(keys)


async def asked(keys: int, *, after_s: float) -> float:
    """How long a question waited (s) when Enter is pressed so long after it was asked."""
    loop = asyncio.get_running_loop()
    ask, began = terminal.at_terminal(), loop.time()
    assert ask is not None
    loop.call_later(after_s, os.write, keys, b"\n")
    await asyncio.wait_for(ask(REFIX), 10.0)
    return loop.time() - began


def test_enter_says_that_the_unit_was_turned_over(keyboard, capsys):
    assert asyncio.run(asked(keyboard, after_s=0.05)) >= 0.05
    printed = " ".join(capsys.readouterr().err.split())
    assert REFIX.instruction in printed
    assert "press Enter" in printed


def test_an_enter_pressed_before_it_was_asked_does_not_count(keyboard):
    os.write(keyboard, b"\n\n")
    assert asyncio.run(asked(keyboard, after_s=0.2)) >= 0.2


def test_a_terminal_that_closes_ends_the_run_with_a_sentence(keyboard):
    async def close() -> None:
        asyncio.get_running_loop().call_later(0.05, os.write, keyboard, b"\x04")
        ask = terminal.at_terminal()
        assert ask is not None
        await asyncio.wait_for(ask(REFIX), 10.0)

    with pytest.raises(Unusable, match="terminal was closed before the unit was turned over"):
        asyncio.run(close())


def test_where_standard_input_is_no_terminal_there_is_nobody(monkeypatch, tmp_path):
    with (tmp_path / "empty").open("w+") as file:
        monkeypatch.setattr(sys, "stdin", file)
        assert terminal.at_terminal() is None


# What is shown of an acquisition, on a terminal and elsewhere.

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


# What is foretold of long work.


def test_the_time_left_follows_from_what_is_behind() -> None:
    assert remaining(10.0, 0.25) == ", about 30 s left"
    assert remaining(10.0, 0.01) == ""


def test_each_step_of_explain_is_further_than_the_one_before() -> None:
    shares: list[float] = []
    for step in BEHIND:
        for share in (0.0, 0.5):
            report_progress(lambda now, behind: shares.append(behind), step, share)
    assert shares == sorted(set(shares))
    assert shares[0] >= 0.0
    assert shares[-1] < 1.0


def test_a_share_of_a_step_lies_within_it() -> None:
    shares: list[float] = []
    report_progress(lambda now, behind: shares.append(behind), "search", 1.0)
    following = list(BEHIND)[list(BEHIND).index("search") + 1]
    assert shares == [pytest.approx(BEHIND[following])]


# Tables on standard output.


def test_a_table_of_thousands_of_rows_keeps_its_columns_without_lines(capsys) -> None:
    rows = [(f"r{number}", "转台" if number % 2 else "table") for number in range(FRAMED + 1)]
    print_rows("Runs", ("run", "unit"), rows)
    title, head, *lines = capsys.readouterr().out.splitlines()
    assert (title, head, len(lines)) == ("Runs", "run   unit", FRAMED + 1)
    assert (lines[0], lines[-2], lines[-1]) == ("r0    table", "r499  转台", "r500  table")
