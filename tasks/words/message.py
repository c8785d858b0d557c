"""A message that is not yet put into a language."""

import re
from collections.abc import Hashable, Sequence
from typing import Any

from schemas.text import Argument, Message, Sayable, Statement

CHOICE = re.compile("[a-z]{3,}")  # no name of a segment, and no symbol


def message(id_: str, /, **arguments: Argument) -> Message:
    """A message by its identifier, `room-what` or `room-what.attribute`, and its arguments."""
    return Message(id_, tuple((name, _unsaid(value)) for name, value in arguments.items()))


def _unsaid(value: Argument) -> Argument:
    """What a message keeps of an argument: of a statement the message that it was made of."""
    if isinstance(value, tuple):
        return tuple(map(_unsaid, value))  # type: ignore[arg-type]
    if isinstance(value, Statement):
        words: dict[str, Any] = value.words
        return value.message or Statement(**words)
    return value


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


def kind_of(said: Argument) -> Hashable:
    """What sentences share that differ in names, figures and axes alone: their messages with those
    inside them, and the words by which a message chooses what it says. A statement without a
    message is of a kind of its own.
    """
    if isinstance(said, Statement):
        return tuple(said.words.items()) if said.message is None else kind_of(said.message)
    if isinstance(said, Message):
        id_ = said.id.removesuffix("x").removesuffix("y").removesuffix("z")
        return id_, *((name, kind_of(value)) for name, value in said.arguments)
    if isinstance(said, tuple):
        return frozenset(map(kind_of, said))
    return said if isinstance(said, str) and CHOICE.fullmatch(said) else None


def argument(said: Argument, name: str) -> Argument | None:
    """The first argument of such a name in a message, or in those inside it."""
    if isinstance(said, Statement):
        return argument(said.message, name) if said.message else None
    if not isinstance(said, Message):
        return None
    own = dict(said.arguments)
    inside = (argument(value, name) for value in own.values())
    return own[name] if name in own else next((each for each in inside if each is not None), None)
