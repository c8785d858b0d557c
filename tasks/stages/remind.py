"""Stage: which units are due for recalibration."""

from datetime import date, timedelta

from storage.catalogue import certificates
from storage.catalogue.certificates import Due
from storage.home import Home


def due_within(home: Home, days: int) -> list[Due]:
    """The units whose newest certificate falls due within so many days from today, or has."""
    return certificates.due(home, date.today() + timedelta(days=days))
