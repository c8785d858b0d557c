"""Reads and commands a described device, whatever its protocol."""

from collections.abc import Mapping
from contextlib import AbstractAsyncContextManager
from typing import Any, Protocol

from schemas.base import Unusable
from schemas.described import Described

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
