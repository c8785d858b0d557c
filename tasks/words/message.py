"""A message that is not yet put into a language."""

from collections.abc import Sequence
from dataclasses import dataclass

from schemas.text import Statement


@dataclass(frozen=True)
class Message:
    """Which sentence of the catalogues, and its named arguments.

    Numbers that are measured come as text, rounded where they are made; whole numbers come as
    they are, so that a catalogue can tell one from many. A message or a published statement
    within a message is said in the same language, a tuple of them as a list.
    """

    id: str
    arguments: tuple[tuple[str, "Argument"], ...] = ()


Sayable = Message | Statement | str
Argument = Sayable | int | tuple[Sayable | int, ...]


def message(id_: str, /, **arguments: Argument) -> Message:
    """A message by its identifier, `room-what` or `room-what.attribute`, and its arguments."""
    return Message(id_, tuple(arguments.items()))


def clauses(parts: Sequence[Sayable], by: str = "clause-sequence") -> Sayable:
    """Several clauses as one, with semicolons between them; empty text for none.

    by: the message that joins `first` and `rest`.
    """
    if not parts:
        return ""
    *before, joined = parts
    for part in reversed(before):
        joined = message(by, first=part, rest=joined)
    return joined
