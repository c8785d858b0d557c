"""Lets nothing of a play survive it, however it ends.

The play is a process of its own. This one adopts whatever of it loses its parent, waits, and ends
what is left; it ends the play where it is itself ended.
"""

import ctypes
import os
import signal
import sys
from collections.abc import Callable
from typing import NoReturn

import psutil

from tests.proof.factory.part import end_all

_SET_DEATH_SIGNAL, _SET_SUBREAPER = 1, 36  # of prctl(2)
STOPPING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def guarded(play: Callable[[], int]) -> int:
    """What the play answers, once nothing is left of it."""
    adopt()
    guard = os.getpid()
    child = os.fork()
    if child == 0:
        _play(guard, play)
    for each in STOPPING:  # a terminal's Ctrl-C reaches the play by itself
        signal.signal(each, lambda number, _: _pass_on(child, number))
    _, status = os.waitpid(child, 0)
    end_all(left())
    return os.waitstatus_to_exitcode(status)


def adopt() -> None:
    """From now on, processes below this one that lose their parent become its own."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_SUBREAPER, 1)


def left() -> list[psutil.Process]:
    """What lives below this process."""
    alive = []
    for each in psutil.Process().children(recursive=True):
        try:
            if each.status() != psutil.STATUS_ZOMBIE:
                alive.append(each)
        except psutil.Error:
            continue
    return alive


def _pass_on(child: int, number: int) -> None:
    if number != signal.SIGINT:
        os.kill(child, number)


def _play(guard: int, play: Callable[[], int]) -> NoReturn:
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SET_DEATH_SIGNAL, signal.SIGTERM)
    signal.signal(signal.SIGTERM, _interrupt)
    signal.signal(signal.SIGHUP, _interrupt)
    code = 1
    try:
        if os.getppid() == guard:
            code = play()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def _interrupt(*_: object) -> NoReturn:
    raise KeyboardInterrupt
