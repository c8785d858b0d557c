"""The terminal: who sits at it, which signals come from it, and what it shows of results."""

import asyncio
import hashlib
import json
import os
import pty
import signal
import sys
import threading
from collections.abc import Iterator

import pytest
from rich.console import Console

from flows import acquisition_view, terminal
from flows.shown_results import print_calibration
from flows.signals import ENDINGS, ending_as_ctrl_c, pausing, stopping
from flows.terminal import FRAMED, print_rows, remaining
from schemas.base import Unusable
from schemas.calibration import Information
from schemas.procedure import Procedure, Refix
from schemas.recording import Alarm
from tasks.calibrate.calibrate import calibrate
from tasks.explain.progress import BEHIND, report_progress
from tasks.specifications.jjf2003 import JJF2003
from tasks.station import procedures
from tasks.station.acquisition import Progress
from tasks.station.connected_station import OPERATOR, StopSwitch

# The person at the terminal, on a terminal of its own.

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


def test_a_terminal_shows_state_segment_time_rates_noise_and_alarms():
    console = Console(width=100)
    with console.capture() as captured:
        console.print(acquisition_view.view(TURNING))
    printed = captured.get()
    assert [text for text in SHOWN if text not in printed] == []


def test_elsewhere_a_line_comes_now_and_then(capsys, monkeypatch):
    clock = iter((0.0, 10.0, 30.0, 30.0, 59.0))
    monkeypatch.setattr(acquisition_view.time, "monotonic", lambda: next(clock))
    show = acquisition_view.plain_lines()
    for _ in range(3):
        show(TURNING)
    (line,) = capsys.readouterr().err.splitlines()
    assert [text for text in SHOWN if text not in line] == []


def test_station_status_says_how_each_run_stands(mimucal, home):
    from storage.home import Home
    from tests.storage.test_stations import status, write_status

    write_status(status("measuring"), Home(home))
    (run,) = mimucal("station", "status", "--json").json["runs"]
    assert (run["station"], run["state"], run["is_dead"]) == ("T1", "stopped", False)
    printed = mimucal("station", "status").out
    assert "stopped: x; 1 of 2" in printed
    assert "ended without a word" in printed


# What is foretold of long work.


def test_the_time_left_follows_from_what_is_behind():
    assert remaining(10.0, 0.25) == ", about 30 s left"
    assert remaining(10.0, 0.01) == ""


def test_each_step_of_explain_is_further_than_the_one_before():
    shares: list[float] = []
    for step in BEHIND:
        for share in (0.0, 0.5):
            report_progress(lambda now, behind: shares.append(behind), step, share)
    assert shares == sorted(set(shares))
    assert shares[0] >= 0.0
    assert shares[-1] < 1.0


def test_a_share_of_a_step_lies_within_it():
    shares: list[float] = []
    report_progress(lambda now, behind: shares.append(behind), "search", 1.0)
    following = list(BEHIND)[list(BEHIND).index("search") + 1]
    assert shares == [pytest.approx(BEHIND[following])]


# Tables on standard output.


def test_a_table_of_thousands_of_rows_keeps_its_columns_without_lines(capsys):
    rows = [(f"r{number}", "转台" if number % 2 else "table") for number in range(FRAMED + 1)]
    print_rows("Runs", ("run", "unit"), rows)
    title, head, *lines = capsys.readouterr().out.splitlines()
    assert (title, head, len(lines)) == ("Runs", "run   unit", FRAMED + 1)
    assert (lines[0], lines[-2], lines[-1]) == ("r0    table", "r499  转台", "r500  table")


# Signals that end a command.


@pytest.mark.parametrize("ending", ENDINGS)
def test_whatever_ends_a_command_ends_it_as_ctrl_c(ending):
    before = signal.getsignal(ending)
    with pytest.raises(KeyboardInterrupt), ending_as_ctrl_c():
        signal.raise_signal(ending)
    assert signal.getsignal(ending) is before


def test_a_second_signal_does_not_break_off_what_the_first_began():
    with ending_as_ctrl_c():
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGHUP)


def test_a_signal_that_was_ignored_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with ending_as_ctrl_c():
            signal.raise_signal(signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)


def test_ctrl_z_pauses_and_the_next_one_goes_on():
    before = signal.getsignal(signal.SIGTSTP)
    paused = []
    with pausing() as is_paused:
        for _ in range(3):
            paused.append(is_paused())
            signal.raise_signal(signal.SIGTSTP)
    assert paused == [False, True, False]
    assert signal.getsignal(signal.SIGTSTP) is before


def test_signals_press_the_switch_of_what_runs_and_act_as_ctrl_c_otherwise():
    switch = StopSwitch()
    before = signal.getsignal(signal.SIGTERM)
    with stopping(switch):
        switch.is_live = True
        for each in (signal.SIGTERM, signal.SIGTERM, signal.SIGINT):
            signal.raise_signal(each)
        assert switch.by == OPERATOR
        switch.is_live = False
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) is before


def test_a_signal_presses_it_while_the_main_thread_is_held_up():
    switch = StopSwitch()
    switch.is_live = True
    with stopping(switch):
        # one long call of C: Python handles the signal only after it
        threading.Timer(0.05, os.kill, [os.getpid(), signal.SIGTERM]).start()
        hashlib.pbkdf2_hmac("sha256", b"x", b"y", 2_000_000)
        assert switch.by == OPERATOR


# `mimucal show RUN --log`.

ENTRY = {"at": "2026-03-01T08:00:00Z", "t": 1.5, "state": "paused", "en": "A rest.", "zh": "暂停。"}


@pytest.fixture
def with_log(copied):
    """A recording whose manifest keeps this log."""

    def write(log):
        folder = copied("real/ferraris_session")
        path = folder / "manifest.json"
        manifest = json.loads(path.read_text(encoding="utf-8"))
        path.write_text(json.dumps(manifest | {"log": log}), encoding="utf-8")
        return folder

    return write


def test_the_log_comes_back_as_it_was_kept(mimucal, with_log):
    folder = with_log([ENTRY])
    document = mimucal("show", folder, "--log", "--json").json
    assert document["format"] == "mimu-run-log/1"
    assert document["log"] == [ENTRY]
    printed = mimucal("show", folder, "--log").out
    assert "2026-03-01 08:00:00" in printed
    assert "A rest." in printed


def test_a_run_without_a_log_says_so(mimucal, shared):
    done = mimucal("show", shared / "real/ferraris_session", "--log")
    assert done.code == 2
    assert "has no log" in done.err


@pytest.mark.parametrize("log", ["text", [{"at": "yesterday"}], {"state": "paused"}])
def test_a_log_of_others_that_is_not_understood_is_refused(mimucal, with_log, log):
    done = mimucal("show", with_log(log), "--log")
    assert done.code == 2
    assert "is not understood" in done.err
    assert done.err.count("\n") == 1


# What `mimucal calibrate` prints for a person.


def test_information_is_a_second_table_with_its_sentences(ideal_run, capsys):
    shown = {
        "noise": Information(
            title="Angle random walk", title_zh="随机游走", unit="deg/sqrt(h)",
            value={"x": 0.08433}, U={"x": 0.00134}, en="From [18] rests.", zh="静止数据。",
        ),
        "floor": Information(
            title="Bias instability", title_zh="零偏不稳定性", unit="deg/h",
            value={"x": None}, en="No floor.", zh="未见最小值。",
        ),
    }  # fmt: skip
    made = calibrate(JJF2003, ideal_run(), run="r", code_version="v")
    print_calibration(made.model_copy(update={"information": shown}))
    first, second = capsys.readouterr().out.split("for information, not decided on")
    assert "Gyro scale factor" in first
    row = next(line for line in second.splitlines() if "│ Angle random walk" in line)
    assert [cell.strip() for cell in row.split("│")[2:7]] == ["x", "0.0843", "0.0014", "2", "°/√h"]
    assert "From [18] rests." in second
    assert "│ Bias instability" not in second
    assert "· Bias instability: No floor." in second
