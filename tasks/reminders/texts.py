"""The text of a reminder."""

from datetime import timedelta

from schemas.recall import Recalled
from schemas.text import Statement
from tasks.words import message, say


def title(recalled: Recalled, days: int, language: str) -> str:
    """The subject of a message on an occasion, days after the due date."""
    return say(
        message(f"recall-title.{_side(days)}", unit=recalled.unit, due=recalled.due.isoformat()),
        language,
    )


def body(recalled: Recalled, days: int, language: str) -> str:
    """The message: which unit, by which certificate, and how many days from then."""
    day = recalled.due + timedelta(days=days)
    english, chinese = recalled.laboratory
    return say(
        message(
            f"recall-body.{_side(days)}", unit=recalled.unit, certificate=recalled.certificate,
            issued=recalled.issued_on.isoformat(), due=recalled.due.isoformat(),
            days=str(abs(days)), day=day.isoformat(), laboratory=Statement(en=english, zh=chinese),
        ),
        language,
    )  # fmt: skip


def _side(days: int) -> str:
    return "before" if days < 0 else "after"
