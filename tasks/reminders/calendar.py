"""Due dates as calendars (RFC 5545): one entry with a message, and the feed of a client."""

from collections.abc import Iterable
from datetime import datetime, timedelta
from typing import TYPE_CHECKING

from schemas.reminders import DueUnit
from tasks.words import message, say

if TYPE_CHECKING:
    from icalendar import Event

PRODUCT = "-//mimucal//recalibration//"


def calendar(
    due_units: Iterable[DueUnit], language: str, now: datetime, sequence: int = 0
) -> bytes:
    """An all-day entry on each due date.

    The entry of a certificate keeps its UID, so that a later one takes the place of an earlier;
    sequence: which one it is.
    """
    from icalendar import Calendar  # late: most days nothing is due

    made = Calendar()
    made.add("version", "2.0")
    made.add("prodid", PRODUCT + language.upper())
    made.add("method", "PUBLISH")
    for each in due_units:
        made.add_component(_event(each, language, now, sequence))
    return made.to_ical()


def _event(due_unit: DueUnit, language: str, now: datetime, sequence: int) -> "Event":
    from icalendar import Event

    event = Event()
    event.add("uid", f"recalibration-{due_unit.certificate}@mimucal")
    event.add("dtstamp", now)
    event.add("sequence", sequence)
    event.add("dtstart", due_unit.due)
    event.add("dtend", due_unit.due + timedelta(days=1))
    event.add("transp", "TRANSPARENT")
    event.add("summary", say(message("reminder-entry", unit=due_unit.unit), language))
    event.add(
        "description",
        say(message("reminder-entry-of", certificate=due_unit.certificate), language),
    )
    return event
