"""When a table came to rest, by the gyros of the unit on it: they know nothing of who stops it."""

import socket
import threading
import time
from urllib.parse import urlsplit

import numpy as np

from schemas.station import StationFile
from tests.proof.kills.tap import FRAME

MOVES_RAD_S = np.radians(2.0)  # above bias, noise and Earth's rate
LOOKED_AT = 3  # frames, whose median counts


class Observed:
    """Reads a unit's line, and notes when it turned last (s, monotonic). lsb: of gyros, rad/s."""

    def __init__(self, station: StationFile, lsb: float) -> None:
        unit = urlsplit(station.unit_link.url)
        self._line = socket.create_connection((str(unit.hostname), int(unit.port or 0)), 10.0)
        self._lsb = lsb
        self.moved_s = self.read_s = 0.0
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        data = b""
        try:
            while part := self._line.recv(65536):
                data += part
                whole = len(data) // (LOOKED_AT * FRAME.size) * (LOOKED_AT * FRAME.size)
                frames, data = data[:whole], data[whole:]
                counts = np.array([frame[3:6] for frame in FRAME.iter_unpack(frames)])
                if len(counts):
                    rates = np.abs(np.median(counts.reshape(-1, LOOKED_AT, 3), axis=1)) * self._lsb
                    self.read_s = time.monotonic()
                    # of frames that came together the last ones tell
                    if rates[-1].max() > MOVES_RAD_S:
                        self.moved_s = self.read_s
        except OSError:
            pass  # hung up

    @property
    def turns(self) -> bool:
        return self.read_s - self.moved_s < 0.1

    def close(self) -> None:
        """Read no more."""
        self._line.shutdown(socket.SHUT_RDWR)
        self._thread.join()
        self._line.close()
