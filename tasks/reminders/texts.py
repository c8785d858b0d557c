"""The text of a reminder."""

from datetime import timedelta

from schemas.reminders import DueUnit
from schemas.text import Statement
from tasks.words import message, say


def title(due_unit: DueUnit, days: int, language: str) -> str:
    """The subject of a message on an occasion, days after the due date."""
    return say(
        message(f"reminder-title.{_side(days)}", unit=due_unit.unit, due=due_unit.due.isoformat()),
        language,
    )


def body(due_unit: DueUnit, days: int, language: str) -> str:
    """The message: which unit, by which certificate, and how many days from then."""
    day = due_unit.due + timedelta(days=days)
    english, chinese = due_unit.laboratory
    return say(
        message(
            f"reminder-body.{_side(days)}", unit=due_unit.unit, certificate=due_unit.certificate,
            issued=due_unit.issued_on.isoformat(), due=due_unit.due.isoformat(),
            days=str(abs(days)), day=day.isoformat(), laboratory=Statement(en=english, zh=chinese),
        ),
        language,
    )  # fmt: skip


def _side(days: int) -> str:
    return "before" if days < 0 else "after"
