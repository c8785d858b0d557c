"""The unit's line, read by a thread so that no byte is lost while the run is busy."""

import logging
import queue
import socket
import threading
import time
from pathlib import Path
from typing import Any, Protocol

import serial

from schemas.base import Unusable
from schemas.unit_link import UnitLink
from tasks.station.drivers.modbus import host_and_port
from tasks.words import message

LOG = logging.getLogger("mimucal.station.unit")
READ_BYTES = 4096
READ_TIMEOUT_S = 0.05


class Source(Protocol):
    """Where bytes come from. Both raise OSError where nothing more will come."""

    def read(self, most: int, /) -> bytes:
        """What has come, after READ_TIMEOUT_S at the latest."""

    def close(self) -> None: ...


class UnitLine:
    """Reads from when it is made until it is closed. Raises Unusable where it cannot be opened."""

    def __init__(self, link: UnitLink) -> None:
        self._link = link
        self._chunks: queue.SimpleQueue[tuple[float, bytes]] = queue.SimpleQueue()
        self._done = threading.Event()
        self.broken: str | None = None
        try:
            self._source = _opened(link)
        except (OSError, ValueError) as error:  # pyserial's own is an OSError
            raise Unusable(
                f"the unit's line {link.url} cannot be opened ({error}): check the cable "
                f"and unit_link.url of the station file",
                message("station-cause.line", unit=link.url),
            ) from error
        LOG.info("opened", extra={"of": link.url})
        self._thread = threading.Thread(target=self._read, name="unit", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Read to the end, and hang up."""
        self.end()
        self._source.close()

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
        while not self._done.is_set():
            try:
                chunk = self._source.read(READ_BYTES)
            except OSError as error:
                self.broken = (
                    f"the unit's line {self._link.url} broke ({error}): check the unit and the "
                    f"cable"
                )
                LOG.error("broken", extra={"of": self._link.url, "cause": str(error)})
                return
            if chunk:
                self._chunks.put((time.monotonic(), chunk))


def _opened(link: UnitLink) -> Source:
    if link.url.startswith("udp://"):
        return _Udp(link.url)
    if link.url.startswith("file://"):
        return _File(Path(link.url.removeprefix("file://")))
    return _Serial(link)


class _Serial:
    """A serial line or a TCP connection, whatever pyserial opens."""

    def __init__(self, link: UnitLink) -> None:
        self._port: Any = serial.serial_for_url(
            link.url, baudrate=link.baudrate, timeout=READ_TIMEOUT_S
        )

    def read(self, most: int) -> bytes:
        """What has come; a socket of pyserial does not tell how much that is."""
        data: bytes = self._port.read(most)
        return data

    def close(self) -> None:
        self._port.close()


class _Udp:
    """Datagrams sent to an address of this machine."""

    def __init__(self, url: str) -> None:
        address = host_and_port(url.replace("udp://", "socket://", 1))
        assert address is not None
        family = socket.AF_INET6 if ":" in address[0] else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._socket.bind(address)
        except OSError:
            self._socket.close()
            raise
        self._socket.settimeout(READ_TIMEOUT_S)

    def read(self, most: int) -> bytes:
        """The next datagram, if one comes."""
        try:
            return self._socket.recv(most)
        except TimeoutError:
            return b""

    def close(self) -> None:
        self._socket.close()


class _File:
    """A file that another program is writing, from its end on."""

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise OSError("there is no such file")
        self._file = path.open("rb")
        self._file.seek(0, 2)

    def read(self, most: int) -> bytes:
        """What was written since."""
        data = self._file.read(most)
        if not data:
            time.sleep(READ_TIMEOUT_S)
        return data

    def close(self) -> None:
        self._file.close()
