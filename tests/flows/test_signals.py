"""Signals that end a command."""

import signal

import pytest

from flows.signals import ENDINGS, ending_as_ctrl_c, pausing


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
