"""The unit's serial line, read by a thread so that no byte waits for the run."""

import queue
import threading
import time
from typing import Any

from schemas.base import Unusable
from schemas.station import AnyLink

READ_BYTES = 4096
READ_TIMEOUT_S = 0.05


class SerialLine:
    """Reads from when it is made until it is closed. Raises Unusable where it cannot be opened."""

    def __init__(self, link: AnyLink) -> None:
        import serial

        self._link = link
        self._chunks: queue.SimpleQueue[tuple[float, bytes]] = queue.SimpleQueue()
        self._done = threading.Event()
        self.broken: str | None = None
        try:
            self._port: Any = serial.serial_for_url(
                link.url, baudrate=link.baudrate, timeout=READ_TIMEOUT_S
            )
        except (serial.SerialException, OSError, ValueError) as error:
            raise Unusable(
                f"the unit's line {link.url} cannot be opened ({error}): check the cable "
                f"and unit_link.url of the station file"
            ) from error
        self._thread = threading.Thread(target=self._read, name="unit", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Read to the end, and hang up."""
        self.end()
        self._port.close()

    def end(self) -> None:
        """Read what is on the line now, and no more."""
        self._done.set()
        self._thread.join()

    def received(self) -> tuple[bytes, float]:
        """What came since the last call, and the time.monotonic() at which the last came."""
        chunks = []
        arrived_s = 0.0
        while not self._chunks.empty():
            arrived_s, chunk = self._chunks.get_nowait()
            chunks.append(chunk)
        return b"".join(chunks), arrived_s

    def _read(self) -> None:
        import serial

        while not self._done.is_set():
            try:
                chunk = self._port.read(READ_BYTES)
            except (serial.SerialException, OSError) as error:
                self.broken = (
                    f"the unit's line {self._link.url} broke ({error}): check the unit and the "
                    f"cable"
                )
                return
            if chunk:
                self._chunks.put((time.monotonic(), chunk))
