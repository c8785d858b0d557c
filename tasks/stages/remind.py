"""Stage: which units are due for recalibration."""

from datetime import date, timedelta

from storage import store
from storage.home import Home
from storage.store import Due


def due_within(home: Home, days: int) -> list[Due]:
    """The units whose newest certificate falls due within so many days from today, or has."""
    return store.due(home, date.today() + timedelta(days=days))
