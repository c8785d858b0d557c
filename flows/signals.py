"""Every terminating signal acts as Ctrl-C does; Ctrl-Z pauses an acquisition."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

Handler = Callable[[int, FrameType | None], None]
ENDINGS = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


def as_ctrl_c(_: int, frame: FrameType | None) -> None:
    """Handle a signal as Ctrl-C, even where Ctrl-C is ignored, as in a script's background."""
    handler = signal.getsignal(signal.SIGINT)
    (handler if callable(handler) else signal.default_int_handler)(signal.SIGINT, frame)


def end_as_ctrl_c(handler: Handler = as_ctrl_c) -> None:
    """Applies from now on; ignored signals, such as SIGHUP under nohup, stay ignored."""
    for ending in ENDINGS:
        if signal.getsignal(ending) is not signal.SIG_IGN:
            signal.signal(ending, handler)


@contextmanager
def ending_as_ctrl_c() -> Iterator[None]:
    """Inside a flow, whose own handler would lose the path of the recording.

    Only the first signal counts: one more, as of a worker and of the run itself at once, would
    break off the stopping of the table.
    """
    if threading.current_thread() is not threading.main_thread():  # no signal comes here
        yield
        return
    before = {ending: signal.getsignal(ending) for ending in ENDINGS}
    came: list[int] = []

    def first_as_ctrl_c(number: int, frame: FrameType | None) -> None:
        came.append(number)
        if len(came) == 1:
            as_ctrl_c(number, frame)

    end_as_ctrl_c(first_as_ctrl_c)
    try:
        yield
    finally:
        for ending, handler in before.items():
            signal.signal(ending, handler)


@contextmanager
def pausing() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-Z (SIGTSTP) was pressed an odd number of times since the block began."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: False
        return
    presses: list[int] = []
    before = signal.signal(signal.SIGTSTP, lambda number, _: presses.append(number))
    try:
        yield lambda: len(presses) % 2 == 1
    finally:
        signal.signal(signal.SIGTSTP, before)
