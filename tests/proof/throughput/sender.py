"""A unit that does nothing but send: frames with a counter and a CRC, at an even rate.

`python -m tests.proof.throughput.sender RATE` prints its port, and ends with standard input.
"""

import socket
import struct
import sys
import threading
import time
import zlib
from contextlib import suppress

SLICE_S = 0.005
BODY = struct.Struct("<2sIQ6i")
LINK = {
    "frame": {
        "kind": "binary", "sync": "aa55", "check": "crc32",
        "fields": [
            {"name": "counter", "type": "uint32"},
            {"name": "time", "type": "uint64", "unit": "us"},
            *({"name": f"gyro_{axis}", "type": "int32", "scale": 1e-7} for axis in "xyz"),
            *({"name": f"accel_{axis}", "type": "int32", "scale": 1e-6} for axis in "xyz"),
        ],
    }
}  # fmt: skip


def frames(first: int, end: int, rate_hz: float) -> bytes:
    """The frames of some numbers; readings that differ from one to the next."""
    sent = []
    for number in range(first, end):
        readings = ((number * 7919 + 104729 * place) % 2000 - 1000 for place in range(6))
        body = BODY.pack(b"\xaa\x55", number, round(number * 1e6 / rate_hz), *readings)
        sent.append(body + struct.pack("<I", zlib.crc32(body)))
    return b"".join(sent)


def send(client: socket.socket, rate_hz: float) -> None:
    """Send from now on, as many as are due."""
    began_s, number = time.monotonic(), 0
    with suppress(ConnectionError):  # the client has what it wanted
        while True:
            due = int((time.monotonic() - began_s) * rate_hz)
            client.sendall(frames(number, due, rate_hz))
            number = due
            time.sleep(SLICE_S)


def main(rate_hz: float) -> None:
    """Send to the first client until standard input ends."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        print(server.getsockname()[1], flush=True)
        client, _ = server.accept()
        threading.Thread(target=send, args=(client, rate_hz), daemon=True).start()
        sys.stdin.read()


if __name__ == "__main__":
    main(float(sys.argv[1]))
