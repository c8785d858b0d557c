"""A unit that is told lines of text, and answers among the frames that it goes on sending."""

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress


@contextmanager
def unit(answer: Callable[[bytes], bytes]) -> Iterator[tuple[str, list[bytes]]]:
    """Its address, and the lines that it was told."""
    received: list[bytes] = []

    def serve(server: socket.socket) -> None:
        client, _ = server.accept()
        with client, suppress(OSError):
            for line in client.makefile("rb"):
                received.append(line)
                client.sendall(b"\xaa\x55frame" + answer(line) + b"\xaa\x55frame")

    with socket.create_server(("127.0.0.1", 0)) as server:
        thread = threading.Thread(target=serve, args=(server,), daemon=True)
        thread.start()
        try:
            yield f"socket://127.0.0.1:{server.getsockname()[1]}", received
        finally:  # where nobody connected, an empty connection ends the wait for one
            socket.create_connection(server.getsockname()).close()
            thread.join(5.0)
