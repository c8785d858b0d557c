"""A message that is not yet put into a language."""

from collections.abc import Sequence
from dataclasses import dataclass

from schemas.text import Statement


@dataclass(frozen=True)
class Message:
    """A sentence of the catalogues, by its identifier, and its named arguments.

    Measured numbers are given as text, rounded where they are made; whole numbers as numbers, so
    that a catalogue can choose singular or plural. A message or a published statement inside a
    message is rendered in the same language, a tuple of them as a list.
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
