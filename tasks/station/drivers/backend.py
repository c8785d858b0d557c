"""Reads and commands a described device, whatever its protocol."""

import math
import re
import time
from collections.abc import Mapping
from contextlib import AbstractAsyncContextManager
from typing import Any, Protocol

import serial

from schemas.base import Unusable
from schemas.described import Described
from schemas.recording import Unit
from schemas.unit_link import SerialQuery, UnitLink
from tasks.words import message

Values = Mapping[str, Any]  # by name; a tuple with one for each axis where it is of an axis


class Backend(Protocol):
    """Reads values by name and gives commands. Raises Unusable where the device does not answer.

    per_axis: the names that are read of each axis.
    """

    url: str

    @property
    def per_axis(self) -> frozenset[str]: ...

    def alone(self) -> AbstractAsyncContextManager[Any]:
        """A block in which nothing of another stands between the exchanges of `read`."""

    async def read(self, names: frozenset[str], after: str = "") -> Values:
        """The values, in as few exchanges as can be; `time` is read in the last of them.

        after: a command without values that goes before, in the same exchange where it can.
        """

    async def command(self, name: str, given: Mapping[str, float], axis: int = 0) -> None:
        """Carry out a command of the description; nothing where it has none of that name."""

    def close(self) -> None:
        """Hang up; the next exchange connects again."""


async def check_expected(described: Described, backend: Backend, what: str) -> None:
    """Read what the description expects and its flags ask for.

    Raises Unusable where that cannot be read, or is not what is expected.
    """
    asked = frozenset((*described.expect, *(flag.of for flag in described.flags.values())))
    if not asked:
        return
    values = await backend.read(asked)
    for name, expected in described.expect.items():
        found = values[name]
        for each in found if isinstance(found, tuple) else (found,):
            if each != expected:
                raise Unusable(
                    f"the {what} at {backend.url} reads {each} as {name} where the station file "
                    f"expects {expected}: check its url, or describe this {what} there"
                )


# The serial number of the unit that is mounted, as the unit itself tells it.

OTHER_UNIT = "station-cause.other-unit"
ANSWER_S = 2.0
ASK_EVERY_S = 0.5  # a unit that is busy drops a line; 4 requests in all
READ_TIMEOUT_S = 0.05
READ_BYTES = 4096
LONGEST = 64  # characters of a serial number


def confirm(unit: Unit, link: UnitLink) -> str | None:
    """The serial number of the unit at a link; None where its description has no `identify`.

    Raises Unusable where it is not that of `unit`, and where the unit does not tell it.
    """
    if link.identify is None:
        return None
    try:
        serial = serial_of(link, link.identify)
    except Unusable as fault:
        raise Unusable(str(fault), message("station-cause.no-serial", unit=unit.serial)) from fault
    if serial != unit.serial:
        raise Unusable(
            f"the unit on {link.url} says that it is {serial}, and the run is ordered for "
            f"{unit.serial}: mount {unit.serial}, or order {serial}",
            message(OTHER_UNIT, found=serial, ordered=unit.serial),
        )
    return serial


def serial_of(link: UnitLink, query: SerialQuery) -> str:
    """What the unit answers; raises Unusable where it does not, or its line cannot be opened."""
    try:
        with unit_port(link) as port:
            pattern = rb"([\x21-\x29\x2b\x2d-\x7e ]{1,%d})[,*\r\n]" % LONGEST
            found = asked(
                port, (query.request + query.terminator).encode(),
                re.compile(re.escape(query.answer.encode()) + pattern),
                len(query.answer) + LONGEST + 1, ANSWER_S, ASK_EVERY_S,
            )  # fmt: skip
    except (OSError, ValueError) as error:  # pyserial's own is an OSError
        raise Unusable(
            f"the unit's line {link.url} cannot be opened ({error}): check the cable and "
            "unit_link.url of the station file"
        ) from error
    if found is None:
        raise Unusable(
            f"the unit on {link.url} did not tell its serial number: “{query.request}” was not "
            f"answered with “{query.answer}” within {ANSWER_S:g} s; check its supply, the cable "
            "and unit_link.identify of the station file"
        )
    return found[1].decode("ascii").strip()


def unit_port(link: UnitLink) -> Any:
    """A unit's serial line or TCP connection; raises OSError or ValueError as pyserial does."""
    return serial.serial_for_url(link.url, baudrate=link.baudrate, timeout=READ_TIMEOUT_S)


def asked(
    port: Any, line: bytes, answer: re.Pattern[bytes], longest: int, within_s: float,
    again_s: float = math.inf,
) -> re.Match[bytes] | None:  # fmt: skip
    """The answer to a line, among the frames that the unit continues to send; None: there is none.

    longest: bytes of an answer. within_s: wall time. again_s: after which the line is sent again.
    """
    received, end_s, ask_s = b"", time.monotonic() + within_s, 0.0
    while (now_s := time.monotonic()) < end_s:
        if now_s >= ask_s:
            port.write(line)
            ask_s = now_s + again_s
        received = received[-longest:] + port.read(READ_BYTES)
        if found := answer.search(received):
            return found
    return None
