"""Output of a long run that survives the loss of its reader.

A worker that is killed leaves its flow run writing into a pipe that nobody reads: any line of a
log would then end the run, wherever it is written.
"""

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from threading import Thread

STDOUT, STDERR = 1, 2
PART = 1 << 16  # bytes
REST_S = 1.0  # for what is still on its way; a child that inherited the pipe may keep it open


@contextmanager
def lasting_output() -> Iterator[None]:
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
    relay = Thread(target=_relay, args=(source, reader), daemon=True)
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
