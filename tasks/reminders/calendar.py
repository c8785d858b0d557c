"""Due dates as calendars (RFC 5545): one entry with a message, and the feed of a client."""

from collections.abc import Iterable
from datetime import datetime, timedelta
from typing import TYPE_CHECKING

from schemas.recall import Recalled
from tasks.words import message, say

if TYPE_CHECKING:
    from icalendar import Event

PRODUCT = "-//mimucal//recalibration//"


def calendar(
    recalled: Iterable[Recalled], language: str, now: datetime, sequence: int = 0
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
    for each in recalled:
        made.add_component(_event(each, language, now, sequence))
    return made.to_ical()


def _event(recalled: Recalled, language: str, now: datetime, sequence: int) -> "Event":
    from icalendar import Event

    event = Event()
    event.add("uid", f"recalibration-{recalled.certificate}@mimucal")
    event.add("dtstamp", now)
    event.add("sequence", sequence)
    event.add("dtstart", recalled.due)
    event.add("dtend", recalled.due + timedelta(days=1))
    event.add("transp", "TRANSPARENT")
    event.add("summary", say(message("recall-entry", unit=recalled.unit), language))
    event.add(
        "description",
        say(message("recall-entry-of", certificate=recalled.certificate), language),
    )
    return event
