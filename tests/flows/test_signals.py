"""Signals that end a command."""

import hashlib
import os
import signal
import threading

import pytest

from flows.signals import ENDINGS, ending_as_ctrl_c, pausing, stopping
from tasks.station.connected_station import OPERATOR, StopSwitch


@pytest.mark.parametrize("ending", ENDINGS)
def test_whatever_ends_a_command_ends_it_as_ctrl_c(ending: signal.Signals) -> None:
    before = signal.getsignal(ending)
    with pytest.raises(KeyboardInterrupt), ending_as_ctrl_c():
        signal.raise_signal(ending)
    assert signal.getsignal(ending) is before


def test_a_second_signal_does_not_break_off_what_the_first_began() -> None:
    with ending_as_ctrl_c():
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGHUP)


def test_a_signal_that_was_ignored_stays_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with ending_as_ctrl_c():
            signal.raise_signal(signal.SIGHUP)
    finally:
        signal.signal(signal.SIGHUP, before)


def test_ctrl_z_pauses_and_the_next_one_goes_on() -> None:
    before = signal.getsignal(signal.SIGTSTP)
    paused = []
    with pausing() as is_paused:
        for _ in range(3):
            paused.append(is_paused())
            signal.raise_signal(signal.SIGTSTP)
    assert paused == [False, True, False]
    assert signal.getsignal(signal.SIGTSTP) is before


def test_signals_press_the_switch_of_what_runs_and_act_as_ctrl_c_otherwise() -> None:
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


def test_a_signal_presses_it_while_the_main_thread_is_held_up() -> None:
    switch = StopSwitch()
    switch.is_live = True
    with stopping(switch):
        # one long call of C: Python handles the signal only after it
        threading.Timer(0.05, os.kill, [os.getpid(), signal.SIGTERM]).start()
        hashlib.pbkdf2_hmac("sha256", b"x", b"y", 2_000_000)
        assert switch.by == OPERATOR
