"""Texts of the certificate: labels with their values, and the user's own texts."""

from dataclasses import dataclass
from datetime import date

from schemas.text import Statement
from tasks.words import Argument, Message, Sayable, known, message

NOT_GIVEN = message("certificate-not-given")
NONE = Statement(en="—", zh="—")


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


def given(en: str | None, zh: str | None = None) -> Sayable:
    """A text of the user as it stands, one for every language where only one is there."""
    first, second = literal(en or ""), literal(zh or "")
    return Statement(en=first or second, zh=second or first) if first or second else NOT_GIVEN


def day(when: date | None) -> Sayable:
    """A day, or “not given”."""
    return given(when.isoformat() if when else None)


def quoted(en: str, zh: str) -> Message:
    """A sentence of a result, set as its language writes it."""
    return message("certificate-quoted", text=Statement(en=en, zh=zh))


def first_known(*ids: str, **arguments: Argument) -> Message | None:
    """The first message that the catalogues have."""
    return next((message(id_, **arguments) for id_ in ids if known(id_)), None)


def slug(key: str) -> str:
    """A key of the schemas as a catalogue writes it."""
    return key.replace(" ", "-").replace("_", "-").replace("'", "").lower()
