"""Stage: which units are due for recalibration."""

from datetime import UTC, datetime, timedelta

from storage import store
from storage.home import Home
from storage.store import Due


def due_within(home: Home, days: int) -> list[Due]:
    """The units whose newest certificate falls due within so many days, or has."""
    return store.due(home, datetime.now(UTC).date() + timedelta(days=days))
