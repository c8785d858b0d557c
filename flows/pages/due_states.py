"""How close a due date is: overdue, soon or later."""

from datetime import UTC, date, datetime, timedelta

from flows.pages.states import StepState
from tasks.words import message

SOON = timedelta(days=90)


def today() -> date:
    """The present day, as the reminders have it: by this machine's clock."""
    return datetime.now(UTC).astimezone().date()


def due_state(due: date | None, day: date | None = None) -> StepState:
    """Overdue is bad, and what falls due within 90 days is open. day: the present one."""
    now = day or today()
    if due is None:
        return StepState(message("pages-due-state.none"), "none")
    if due < now:
        return StepState(message("pages-due-state.overdue", days=(now - due).days), "bad")
    days = (due - now).days
    return StepState(
        message("pages-due-state.in", days=days), "open" if due <= now + SOON else "good"
    )
