"""When a reminder is due, when messages are held back, and when a failed one is retried."""

from datetime import date, datetime, timedelta
from zoneinfo import ZoneInfo

from schemas.recall import SilentHours

OCCASIONS = (-60, -30, -7, 7, 30)  # days after the due date; negative: before it
FIRST_PAUSE = timedelta(minutes=5)
LONGEST_PAUSE = timedelta(hours=6)


def occasion(due: date, issued_on: date, today: date) -> int | None:
    """The last occasion that has come; None before the first.

    One from before the issue of the certificate does not count: nobody is reminded of a certificate
    just received.
    """
    come = [
        days for days in OCCASIONS if issued_on < due + timedelta(days=days) <= today
    ]  # fmt: skip
    return come[-1] if come else None


def is_silent(silent: SilentHours | None, now: datetime) -> bool:
    """Whether nothing is sent at a moment; hours that begin in the evening end in the morning."""
    if silent is None:
        return False
    clock = now.astimezone(ZoneInfo(silent.timezone)).time()
    if silent.since <= silent.until:
        return silent.since <= clock < silent.until
    return clock >= silent.since or clock < silent.until


def pause(tries: int) -> timedelta:
    """How long to wait after so many tries, twice as long each time."""
    return min(FIRST_PAUSE * 2 ** min(tries - 1, 16), LONGEST_PAUSE)
