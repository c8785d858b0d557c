"""A device that takes lines of text, read and commanded by its description."""

import asyncio
import logging
import re
import string
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractAsyncContextManager
from typing import Any

import serial

from schemas.base import Unusable
from schemas.described import Query, TextDevice
from tasks.station.clock import wall_s
from tasks.station.drivers.backend import Values
from tasks.words import message

LOG = logging.getLogger("mimucal.station.connection")
ATTEMPTS = 3
MOST_BYTES = 4096  # of an answer
# of each number there is one way to read it: a damaged line must not be tried for ever
NUMBER = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?"
PATTERNS = {"": NUMBER, "x": r"(?:0[xX])?[0-9a-fA-F]+", "w": r"[^\s,;]+", "t": r".*"}


class TextLink:
    """One line, shared by everything on it; one exchange at a time.

    A line that gets no answer is asked again on a new connection, ATTEMPTS times in all, so that
    a late answer is never taken for that of the next line. Raises Unusable, naming the line, when
    there is still no answer.
    """

    def __init__(self, described: TextDevice) -> None:
        self.url = described.url
        self._described = described
        self.alone = asyncio.Lock()  # for the lines of a command, which belong together
        self.paused_until_s = 0.0  # wall time; also where the command before was broken off
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
            LOG.warning("no answer", extra={"of": self.url, "request": line})
        raise Unusable(
            f"the device at {self.url} does not answer “{line}” ({ATTEMPTS} attempts): check that "
            f"it is switched on and connected, and that url, baudrate and terminators in the "
            f"station file are right",
            message("station-cause.silent", device=self.url),
        )

    async def _in_thread(self, line: str, is_answered: bool) -> str | None:
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._thread, self._exchange, line, is_answered)

    def _exchange(self, line: str, is_answered: bool) -> str | None:
        """The answer; None if there was none in time."""
        try:
            port = self._connected()
            if is_answered:
                port.reset_input_buffer()
            port.write((line + self._described.terminator).encode())
            return self._answer(port, line) if is_answered else None
        except (serial.SerialException, OSError, ValueError) as error:
            self._hang_up()
            if is_answered:
                return None
            raise Unusable(
                f"“{line}” cannot be sent to the device at {self.url} ({error}): check that it is "
                f"switched on, and url in the station file",
                message("station-cause.silent", device=self.url),
            ) from error

    def _answer(self, port: Any, line: str) -> str | None:
        end = self._described.answer_terminator.encode()
        answer: bytes = port.read_until(end, MOST_BYTES)
        if not answer.endswith(end):
            self._hang_up()
            return None
        text = answer[: -len(end)].decode(errors="replace").lstrip("\r\n")
        text = text[self._described.answer_header :].strip()
        return text.removeprefix(line.strip()).strip() if self._described.echoes else text

    def _connected(self) -> Any:
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
            LOG.info("connected", extra={"of": line.url})
        return self._port

    def _hang_up(self) -> None:
        port, self._port = self._port, None
        if port is not None:
            port.close()


class Answer:
    """What an answer looks like, made once from its description."""

    def __init__(self, template: str) -> None:
        self._places: list[tuple[str, int | None, str]] = []  # name, axis, how it is written
        pattern = ""
        for literal, name, kind, _ in string.Formatter().parse(template):
            pattern += re.escape(literal)
            if name:
                bare, _, axis = name.partition("[")
                self._places.append((bare, int(axis.rstrip("]")) if axis else None, kind or ""))
                pattern += f"({PATTERNS[kind or '']})"
        self._pattern = re.compile(pattern)

    @property
    def names(self) -> frozenset[str]:
        return frozenset(name for name, _, _ in self._places)

    @property
    def per_axis(self) -> frozenset[str]:
        """The names with an axis in brackets."""
        return frozenset(name for name, axis, _ in self._places if axis is not None)

    def values(self, line: str) -> dict[tuple[str, int | None], Any] | None:
        """What a line holds, by name and axis; None where it does not look like it."""
        match = self._pattern.fullmatch(line)
        if match is None:
            return None
        return {
            (name, axis): _value(text, kind)
            for (name, axis, kind), text in zip(self._places, match.groups(), strict=True)
        }


def _value(text: str, kind: str) -> Any:
    if kind in ("w", "t"):
        return text
    return int(text, 16) if kind == "x" else float(text)


class TextBackend:
    """Implements Backend for `axes` axes. Raises as TextLink does, and for an answer that does
    not look like its description."""

    def __init__(self, described: TextDevice, link: TextLink, axes: int) -> None:
        self.url = link.url
        self._described = described
        self._link = link
        self._axes = axes
        self._queries = [(query, Answer(query.answer)) for query in described.queries]
        # the time is asked for last
        self._queries.sort(key=lambda each: "time" in each[1].names)

    @property
    def per_axis(self) -> frozenset[str]:
        """What is asked for each axis, and what an answer has for each."""
        names: set[str] = set()
        for query, answer in self._queries:
            names |= answer.names if "{axis}" in query.ask else answer.per_axis
        return frozenset(names)

    async def read(self, names: frozenset[str], after: str = "") -> Values:
        """The values by name, one exchange after the other."""
        await self._send(after, {}, 0)
        found: dict[tuple[str, int | None], Any] = {}
        for query, answer in self._queries:
            if not answer.names & names:
                continue
            if "{axis}" not in query.ask:
                found |= await self._ask(query, answer, query.ask)
                continue
            for axis in range(self._axes):
                values = await self._ask(query, answer, query.ask.format(axis=self._name(axis)))
                found |= {(name, axis): value for (name, _), value in values.items()}
        per_axis = self.per_axis
        return {
            name: tuple(self._scaled(name, found[name, axis]) for axis in range(self._axes))
            if name in per_axis
            else self._scaled(name, found[name, None])
            for name in names
        }

    async def command(self, name: str, given: Mapping[str, float], axis: int = 0) -> None:
        """Send the command's lines, one after the other, and nothing in between."""
        async with self.alone():
            await self._send(name, given, axis)

    def alone(self) -> AbstractAsyncContextManager[Any]:
        """A block in which nobody else on this line says anything."""
        return self._link.alone

    async def _send(self, name: str, given: Mapping[str, float], axis: int) -> None:
        scaled = {
            each: value / self._described.scale.get(each, 1.0) for each, value in given.items()
        }
        for template in self._described.commands.get(name, ()):
            await self._tell(template.format(axis=self._name(axis), **scaled))

    async def _tell(self, line: str) -> None:
        """Send a line of a command; raises Unusable where the device says that it did not take it.

        The pause comes before the question for errors, which would come too early otherwise.
        """
        errors, wanted = self._described.errors, self._described.acknowledge
        await self._pause()
        answer = ""
        try:
            if wanted is None:
                await self._link.tell(line)
            else:
                answer = await self._link.ask(line)
        finally:
            self._link.paused_until_s = wall_s() + self._described.pause_s
        if wanted is None:
            if errors is None:
                return
            await self._pause()
            answer, wanted = await self._link.ask(errors.ask), errors.none
        if Answer(wanted).values(answer) is None:
            asked = f" and then “{errors.ask}”" if errors else ""
            raise Unusable(
                f"the device at {self.url} answered “{line}”{asked} with “{answer[:80]}” instead "
                f"of “{wanted}”: see its manual"
            )

    async def _pause(self) -> None:
        await asyncio.sleep(max(self._link.paused_until_s - wall_s(), 0.0))

    def close(self) -> None:
        """Hang up; the next exchange connects again."""
        self._link.close()

    async def _ask(
        self, query: Query, answer: Answer, line: str
    ) -> dict[tuple[str, int | None], Any]:
        text = await self._link.ask(line)
        values = answer.values(text)
        if values is None:
            raise Unusable(
                f"the device at {self.url} answered “{line}” with “{text[:80]}”, but the station "
                f"file expects “{query.answer}”: correct queries there"
            )
        return values

    def _scaled(self, name: str, value: Any) -> Any:
        scale = self._described.scale.get(name)
        return value if scale is None else value * scale

    def _name(self, axis: int) -> str:
        names = self._described.axes
        return names[axis] if names else str(axis + 1)
