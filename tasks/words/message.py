"""A message that is not yet put into a language."""

import re
from collections.abc import Hashable, Sequence
from typing import Any

from schemas.text import Argument, Message, Sayable, Statement

AXIS = re.compile("_[xyz]$")  # as in channel-gyro_x
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


def kind_of(part: Argument) -> Hashable:
    """What sentences share that differ in names, figures and axes alone: their messages with those
    inside them, and the words by which a message chooses what it says. A statement without a
    message is of a kind of its own.
    """
    if isinstance(part, Statement):
        return tuple(part.words.items()) if part.message is None else kind_of(part.message)
    if isinstance(part, Message):
        return AXIS.sub("", part.id), *((name, kind_of(value)) for name, value in part.arguments)
    if isinstance(part, tuple):
        return frozenset(map(kind_of, part))
    return part if isinstance(part, str) and CHOICE.fullmatch(part) else None


def argument(part: Argument, name: str) -> Argument | None:
    """The first argument of such a name in a message, or in those inside it."""
    if isinstance(part, Statement):
        return argument(part.message, name) if part.message else None
    if not isinstance(part, Message):
        return None
    own = dict(part.arguments)
    inside = (argument(value, name) for value in own.values())
    return own[name] if name in own else next((each for each in inside if each is not None), None)
