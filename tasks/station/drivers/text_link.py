"""Lines sent and answered over TCP or a serial line, in a thread that may block."""

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from schemas.base import Unusable
from schemas.described import TextDevice

ATTEMPTS = 3
MOST_BYTES = 4096  # of an answer


class TextLink:
    """One line, shared by everything on it; one exchange at a time.

    A line that gets no answer is asked again on a new connection, ATTEMPTS times in all, so that
    a late answer is never taken for that of the next line. Raises Unusable, naming the line, when
    there is still no answer.
    """

    def __init__(self, described: TextDevice) -> None:
        self.url = described.url
        self._described = described
        self._port: Any = None
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="text")

    def close(self) -> None:
        """Hang up; the next exchange connects again."""
        self._thread.submit(self._hang_up).result()

    async def tell(self, line: str) -> None:
        """Send a line that has no answer. It is sent once: a command twice is another command."""
        await self._in_thread(line, False)

    async def ask(self, line: str) -> str:
        """Send a line; its answer without the terminator."""
        for _ in range(ATTEMPTS):
            answer = await self._in_thread(line, True)
            if answer is not None:
                return answer
        raise Unusable(
            f"the device at {self.url} does not answer “{line}” ({ATTEMPTS} attempts): check that "
            f"it is switched on and connected, and that url, baudrate and terminators in the "
            f"station file are right"
        )

    async def _in_thread(self, line: str, is_answered: bool) -> str | None:
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._thread, self._exchange, line, is_answered)

    def _exchange(self, line: str, is_answered: bool) -> str | None:
        """The answer; None if there was none in time."""
        import serial

        try:
            port = self._connected()
            if is_answered:
                port.reset_input_buffer()
            port.write((line + self._described.terminator).encode())
            return self._answer(port) if is_answered else None
        except (serial.SerialException, OSError, ValueError) as error:
            self._hang_up()
            if is_answered:
                return None
            raise Unusable(
                f"“{line}” cannot be sent to the device at {self.url} ({error}): check that it is "
                f"switched on, and url in the station file"
            ) from error

    def _answer(self, port: Any) -> str | None:
        end = self._described.answer_terminator.encode()
        answer: bytes = port.read_until(end, MOST_BYTES)
        if not answer.endswith(end):
            self._hang_up()
            return None
        return answer[: -len(end)].decode(errors="replace").strip()

    def _connected(self) -> Any:
        import serial

        if self._port is None:
            line = self._described
            self._port = serial.serial_for_url(
                line.url,
                baudrate=line.baudrate,
                parity=line.parity,
                stopbits=line.stopbits,
                timeout=line.timeout_s,
                write_timeout=line.timeout_s,
            )
        return self._port

    def _hang_up(self) -> None:
        port, self._port = self._port, None
        if port is not None:
            port.close()
