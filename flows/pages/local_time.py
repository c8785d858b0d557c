"""Times as people on the line read them: by the clock of the computer that serves the pages.

That is the laboratory's (TZ), whoever looks from wherever: two persons who speak of the same run
read the same time, and a day begins and ends for all at once.
"""

from datetime import UTC, date, datetime

from tasks.words import Message, message


def today() -> date:
    """The present day there."""
    return day_of(datetime.now(UTC))


def day_of(moment: datetime) -> date:
    """The day of a moment there."""
    return moment.astimezone().date()


def second_of(moment: datetime) -> str:
    """“2026-11-27 15:04:05”."""
    return f"{moment.astimezone():%F %T}"


def minute_of(moment: datetime) -> str:
    """“2026-11-27 15:04”."""
    return f"{moment.astimezone():%F %R}"


def day_in(text: str) -> str:
    """The day there of a moment in ISO 8601, its own day where it has no zone; any other text."""
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        return text
    return str(day_of(moment) if moment.tzinfo else moment.date())


def hour_of(moment: datetime) -> str:
    """“15:04” of the present day; of another one with its day."""
    there = moment.astimezone()
    return f"{there:%R}" if there.date() == today() else f"{there:%F %R}"


def zone() -> Message:
    """The sentence that says once on a page which times it shows."""
    now = datetime.now(UTC).astimezone()
    return message("pages-times", zone=f"{now:%Z}", offset=now.isoformat()[-len("+08:00") :])
