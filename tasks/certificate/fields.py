"""Texts of the certificate: labels with their values, and the user's own texts."""

from dataclasses import dataclass
from datetime import date
from typing import Any

from schemas.text import Statement, text_in
from tasks.words import Argument, Message, Sayable, known, message, statement

NOT_GIVEN = message("certificate-not-given")
NONE = statement("—")


@dataclass(frozen=True)
class Field:
    """A label and its value."""

    label: Message
    value: Sayable


def field(label: str, value: Sayable) -> Field:
    """A field by the name of its label."""
    return Field(message(f"certificate-field.{label}"), value)


def literal(text: str) -> str:
    """A text of the user on one line: what has no glyph (control characters) is a space."""
    if not text.isprintable():
        text = "".join(c if c.isprintable() else " " for c in text)
    return " ".join(text.split())


def given(text: Statement | str | None) -> Sayable:
    """A text of the user as it stands, or “not given”."""
    return (text_in([literal(text)]) if isinstance(text, str) else text) or NOT_GIVEN


def day(when: date | None) -> Sayable:
    """A day, or “not given”."""
    return given(when.isoformat() if when else None)


def quoted(text: Statement) -> Message:
    """A sentence of a result, set as its language writes it: in the words that the record has kept,
    whatever the catalogues say by now.
    """
    kept: dict[str, Any] = statement(text).words
    return message("certificate-quoted", text=Statement(**kept))


def first_known(*ids: str, **arguments: Argument) -> Message | None:
    """The first message that the catalogues have."""
    return next((message(id_, **arguments) for id_ in ids if known(id_)), None)


def slug(key: str) -> str:
    """A key of the schemas as a catalogue writes it."""
    return key.replace(" ", "-").replace("_", "-").replace("'", "").lower()
