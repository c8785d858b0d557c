"""The operations pages of a home, served from a thread."""

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Thread

from flows.pages.app import listening
from storage.home import Home

ENDS_WITHIN_S = 5.0


@contextmanager
def served(home: Home) -> Iterator[str]:
    """Where the pages of a home are answered; the server closes on the thread that it runs on."""
    server = listening(home, "127.0.0.1", 0)
    thread = Thread(target=server.run, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.effective_port}"
    finally:
        server.trigger.pull_trigger(server.close)
        thread.join(ENDS_WITHIN_S)
        server.task_dispatcher.shutdown()
