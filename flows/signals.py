"""SIGTERM ends a command as Ctrl-C does."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


def as_ctrl_c(_: int, frame: FrameType | None) -> None:
    """Handle SIGTERM as Ctrl-C, even where Ctrl-C is ignored, as in a script's background."""
    handler = signal.getsignal(signal.SIGINT)
    (handler if callable(handler) else signal.default_int_handler)(signal.SIGINT, frame)


@contextmanager
def sigterm_as_ctrl_c() -> Iterator[None]:
    """SIGTERM as Ctrl-C within a flow, whose own handler would lose where the recording lies."""
    if threading.current_thread() is not threading.main_thread():  # no signal comes here
        yield
        return
    before = signal.signal(signal.SIGTERM, as_ctrl_c)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
