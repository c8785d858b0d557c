"""Every terminating signal acts as Ctrl-C does; Ctrl-Z pauses an acquisition."""

import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tasks.station.connected_station import StopSwitch


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
    # signals are not delivered to this thread
    if threading.current_thread() is not threading.main_thread():
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
def stopping(stop: "StopSwitch") -> Iterator[None]:
    """Inside an acquisition: the signals that end it press its switch, however many come.

    Before and after what the switch ends they act as Ctrl-C does; ignored ones stay ignored.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    from tasks.station.connected_station import OPERATOR

    before = {each: signal.getsignal(each) for each in (signal.SIGINT, *ENDINGS)}
    usual = before[signal.SIGINT]

    def press(number: int, frame: FrameType | None) -> None:
        if stop.is_live:
            stop.press(OPERATOR)
        else:
            (usual if callable(usual) else signal.default_int_handler)(number, frame)

    def press_meanwhile(number: int) -> None:
        if number in before and stop.is_live:
            stop.press(OPERATOR)

    heeded = {each: press for each, handler in before.items() if handler is not signal.SIG_IGN}
    _handle(heeded)
    try:
        with _arriving(press_meanwhile):
            yield
    finally:
        _handle(before)


def _handle(handlers: Mapping[signal.Signals, Any]) -> None:
    for each, handler in handlers.items():
        signal.signal(each, handler)


@contextmanager
def _arriving(act: Callable[[int], object]) -> Iterator[None]:
    """Acts on the number of each signal that arrives, in a thread.

    So it does even while the main thread, in which Python handles signals, is held up.
    """
    reader, writer = os.pipe()
    os.set_blocking(writer, False)

    def watch() -> None:
        while number := os.read(reader, 1):
            act(number[0])

    thread = threading.Thread(target=watch, name="signals", daemon=True)
    thread.start()
    woken = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    try:
        yield
    finally:
        signal.set_wakeup_fd(woken)
        os.close(writer)
        thread.join()
        os.close(reader)


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
