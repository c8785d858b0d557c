"""What a unit sent, as a log of the bytes on its line and when each came by."""

import socket
import struct
import threading
import time
from dataclasses import dataclass, field

import numpy as np

FRAME = struct.Struct("<HIQ3i3ihH")  # deploy/station.md, the frame of rates
SYNC = 0x55AA


@dataclass(frozen=True)
class Sent:
    """Frames as a unit sent them: (n,) when each was passed on (s, monotonic), its stamp (µs), and
    (n, 6) counts of gyros and accelerometers.
    """

    passed_s: np.ndarray
    stamps: np.ndarray
    counts: np.ndarray


@dataclass
class Tap:
    """Stands between a unit and one client on this machine, and logs what it passes on."""

    unit: tuple[str, int]
    _log: list[tuple[float, bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self.url = f"socket://127.0.0.1:{self._server.getsockname()[1]}"
        threading.Thread(target=self._pass_on, daemon=True).start()

    def _pass_on(self) -> None:
        client, _ = self._server.accept()
        with client, socket.create_connection(self.unit) as unit:
            try:
                while data := unit.recv(65536):
                    client.sendall(data)
                    self._log.append((time.monotonic(), data))
            except OSError:
                pass  # the client was killed

    def close(self) -> None:
        """Take no further client."""
        self._server.close()

    def sent(self) -> Sent:
        """Every whole frame that was passed on."""
        log = list(self._log)
        data = b"".join(part for _, part in log)
        ends = np.cumsum([len(part) for _, part in log])
        frames = list(FRAME.iter_unpack(data[: len(data) - len(data) % FRAME.size]))
        if any(frame[0] != SYNC for frame in frames):
            raise ValueError("the unit's line does not hold frame after frame")
        last_bytes = FRAME.size * np.arange(1, len(frames) + 1)
        parts = np.searchsorted(ends, last_bytes)
        return Sent(
            np.array([log[part][0] for part in parts]),
            np.array([frame[2] for frame in frames], dtype=np.int64),
            np.array([frame[3:9] for frame in frames], dtype=np.int64).reshape(-1, 6),
        )
