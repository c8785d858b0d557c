"""What ends or pauses a long run: signals, and the loss of its worker or its reader."""

import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
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


# A flow run that stops by itself where its worker can no longer stop it.
#
# A worker stops its flow run when Prefect cancels it; one that died, or that stopped polling
# because the server was down, does not. The process of the run therefore polls as well.

LOOK_S = 1.0
ASK_EVERY = 3  # looks
FLOW_RUN = "PREFECT__FLOW_RUN_ID"  # set by a worker for the process that it starts
CANCELLED_TYPES = ("CANCELLING", "CANCELLED")


@contextmanager
def cancellation_watch(stop: Callable[[str], object]) -> Iterator[None]:
    """Calls `stop`, once and with the cause, if the worker is gone or Prefect cancels the run.

    It is called in another thread, and only within the block. Outside of a worker's process
    nothing is looked for.
    """
    run = os.environ.get(FLOW_RUN)
    if run is None:
        yield
        return
    from tasks.station.connected_station import CANCELLATION, LOSS

    ended, ending = threading.Event(), threading.Lock()
    worker = os.getppid()

    def look_until_the_end() -> None:
        looks = 0
        while not ended.wait(LOOK_S):
            looks += 1
            is_lost = os.getppid() != worker
            if is_lost or (looks % ASK_EVERY == 0 and is_cancelled(run)):
                with ending:
                    if not ended.is_set():
                        stop(LOSS if is_lost else CANCELLATION)
                return

    threading.Thread(target=look_until_the_end, daemon=True).start()
    try:
        yield
    finally:
        with ending:
            ended.set()


def is_cancelled(run: str) -> bool:
    """Whether Prefect has a flow run as cancelled; False of a server that does not answer."""
    from tasks.stages.prefect_api import NotAnswered, get

    try:
        return get(f"/flow_runs/{run}").get("state_type") in CANCELLED_TYPES
    except NotAnswered:
        return False


# Output of a long run that survives the loss of its reader.
#
# A worker that is killed leaves its flow run writing into a pipe that nobody reads: any line of a
# log would then end the run, wherever it is written.

STDOUT, STDERR = 1, 2
PART = 1 << 16  # bytes
REST_S = 1.0  # for what is still on its way; a child that inherited the pipe may keep it open


@contextmanager
def resilient_output() -> Iterator[None]:
    """Writing within the block never fails, even if the reader is gone. A terminal is left as it
    is: its loss arrives as a signal.
    """
    with ExitStack() as relays:
        for descriptor in (STDOUT, STDERR):
            if not os.isatty(descriptor):
                relays.enter_context(_relayed(descriptor))
        yield


@contextmanager
def _relayed(descriptor: int) -> Iterator[None]:
    """What is written to a descriptor goes through a pipe of our own, which is always read."""
    reader = os.dup(descriptor)
    source, sink = os.pipe()
    os.dup2(sink, descriptor)
    os.close(sink)
    relay = threading.Thread(target=_relay, args=(source, reader), daemon=True)
    relay.start()
    try:
        yield
    finally:
        os.dup2(reader, descriptor)  # closes our pipe, whose end the relay then sees
        relay.join(REST_S)
        if not relay.is_alive():
            os.dup2(reader, descriptor)  # the relay may have lost the reader in the meantime
            os.close(source)
            os.close(reader)


def _relay(source: int, reader: int) -> None:
    """Forwards the output; once the reader is gone, discards it."""
    while part := os.read(source, PART):
        try:
            os.write(reader, part)
        except OSError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, reader)
            os.close(nowhere)
