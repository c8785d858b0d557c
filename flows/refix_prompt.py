"""Asks the person at the terminal to turn the unit over where the station cannot, and who it is."""

import asyncio
import os
import sys
import termios

from flows.progress import CONSOLE
from schemas.base import Unusable
from schemas.procedure import Refix
from schemas.text import text_of
from tasks.station.ports import Ask
from tasks.words import message, texts


def at_terminal() -> Ask | None:
    """The prompt for the person at the terminal; None if standard input is not a terminal."""
    return _ask if sys.stdin is not None and sys.stdin.isatty() else None


def ask_for_operator() -> str | None:
    """The name of the person at the terminal; None without one, or where nothing is answered."""
    if at_terminal() is None:
        return None
    CONSOLE.print(*texts(message("flows-who-operates")).values(), sep=" ", end=" ", markup=False)
    return sys.stdin.readline().strip() or None


async def _ask(refix: Refix) -> None:
    """Says what is to be done and waits for Enter; a key pressed earlier does not count.

    Acquisition continues meanwhile. Raises Unusable if the terminal is closed.
    """
    terminal = sys.stdin.fileno()
    termios.tcflush(terminal, termios.TCIFLUSH)
    if instruction := text_of(refix, "instruction"):
        CONSOLE.print(*instruction.words.values(), sep="\n", markup=False)
    CONSOLE.print(*texts(message("flows-press-enter")).values(), markup=False)
    loop, pressed = asyncio.get_running_loop(), asyncio.Event()
    loop.add_reader(terminal, pressed.set)
    try:
        await pressed.wait()
    finally:
        loop.remove_reader(terminal)
    if not os.read(terminal, 4096):
        raise Unusable("the terminal was closed before the unit was turned over: start again")
