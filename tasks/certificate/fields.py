"""A label and what stands beside it; texts of the user on one line, and «not given»."""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date

from tasks.certificate.names import Pair
from tasks.words.rounding import MINUS

NOT_GIVEN = ("未提供", "not given")


@dataclass(frozen=True)
class Field:
    """A label and what stands beside it."""

    label: Pair
    value: Pair


def literal(text: str) -> str:
    """A text of the user on one line: what has no glyph (control characters) is a space."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def given(zh: str | None, en: str | None = None) -> Pair:
    """Both languages, one for both where only one is there, or «not given»."""
    first, second = literal(zh or ""), literal(en or "")
    return (first or second, second or first) if first or second else NOT_GIVEN


def day(when: date | None) -> Pair:
    """A day, or «not given»."""
    return given(when.isoformat() if when else None)


def number(value: float) -> str:
    """A number as it was given, with a real minus sign."""
    return f"{value:.10g}".replace("-", MINUS)


def listed(parts: Iterable[Pair]) -> Pair:
    """Names one after the other, as each language lists them."""
    both = tuple(parts)
    return "、".join(zh for zh, _ in both), ", ".join(en for _, en in both)
