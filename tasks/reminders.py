"""When a unit is due for recalibration, how that is told, and what its own history advises.

The interval is that of clause 9 of JJF 2003-2022 and of JJF 1536-2015, or what the order agrees on.
"""

import logging
import math
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from typing import TYPE_CHECKING, Literal
from zoneinfo import ZoneInfo

import numpy as np
from dateutil.relativedelta import relativedelta

from schemas.base import Unusable, filled
from schemas.store import DueUnit, SilentHours
from schemas.text import text_in
from tasks.words import message, say

if TYPE_CHECKING:
    from icalendar import Event

OCCASIONS = (-60, -30, -7, 7, 30)  # days after the due date; negative: before it
FIRST_PAUSE = timedelta(minutes=5)
LONGEST_PAUSE = timedelta(hours=6)
PRODUCT = "-//mimucal//recalibration//"
ENTRY = "recalibration.ics"
NO_REASON = "the channel gave no reason"
NOT_ASCII = (
    "user or password has a character beyond ASCII, which a mail server cannot be told: choose "
    "another"
)


def due_date(calibrated_on: date, months: int) -> date:
    """The day `months` calendar months after a calibration.

    A day that the month does not have becomes its last day: one month after 31 January is
    28 or 29 February.
    """
    return calibrated_on + relativedelta(months=months)


# Sends a reminder by the URL of a channel: e-mail with a calendar entry, or a chat message.


def check_channel(name: str, url: str) -> str:
    """The URL of a channel with environment variables filled in; Unusable for an invalid one.

    A password may hold any character, as a variable or as it is; it is never part of a sentence.
    """
    from apprise import Apprise

    try:
        whole = filled(url, os.environ)
    except KeyError as missing:
        raise Unusable(
            f"recall.toml: channel {name!r} uses ${{{missing.args[0]}}}, which is not set in "
            "the environment; set it."
        ) from missing
    except ValueError as error:
        raise Unusable(
            f"recall.toml: channel {name!r} has a dollar without a name; write $$ for a dollar."
        ) from error
    with _warnings():  # they repeat the URL
        is_one = Apprise.instantiate(whole) is not None
    if not is_one:
        raise Unusable(
            f"recall.toml: channel {name!r} is not an Apprise URL (mailto://, dingtalk://, "
            "wecombot://, feishu://, slack://); correct it there."
        )
    return whole


def send(url: str, title: str, body: str, entry: bytes | None) -> str | None:
    """Sends a message; gives why it could not be sent, None where it was.

    entry: a calendar, if any, which goes with it where the channel takes files.
    """
    from apprise import Apprise, AppriseAttachment, NotifyFormat
    from apprise.attachment.memory import AttachMemory

    channel = Apprise.instantiate(url)
    if channel is None:
        return "the channel is not an Apprise URL"
    attached = None
    if entry is not None and channel.attachment_support:
        attached = AppriseAttachment()
        attached.add(AttachMemory(content=entry, name=ENTRY, mimetype="text/calendar"))
    with _warnings() as warned:
        try:
            done = channel.notify(
                body=body, title=title, body_format=NotifyFormat.TEXT, attach=attached
            )  # fmt: skip
        except UnicodeEncodeError:  # whose text would repeat them
            return NOT_ASCII
    if done:
        return None
    return warned[-1] if warned else NO_REASON


@contextmanager
def _warnings() -> Iterator[list[str]]:
    """What Apprise logs as a warning, which is the only place where it says what went wrong."""
    warned: list[str] = []
    catcher = logging.Handler(logging.WARNING)
    catcher.emit = lambda record: warned.append(record.getMessage())  # type: ignore[method-assign]
    logger = logging.getLogger("apprise")
    logger.addHandler(catcher)
    try:
        yield warned
    finally:
        logger.removeHandler(catcher)


def title(due_unit: DueUnit, days: int, language: str) -> str:
    """The subject of a message on an occasion, days after the due date."""
    return say(
        message(f"reminder-title.{_side(days)}", unit=due_unit.unit, due=due_unit.due.isoformat()),
        language,
    )


def body(due_unit: DueUnit, days: int, language: str) -> str:
    """The message: which unit, by which certificate, and how many days from then."""
    day = due_unit.due + timedelta(days=days)
    return say(
        message(
            f"reminder-body.{_side(days)}", unit=due_unit.unit, certificate=due_unit.certificate,
            issued=due_unit.issued_on.isoformat(), due=due_unit.due.isoformat(),
            days=str(abs(days)), day=day.isoformat(), laboratory=text_in(due_unit.laboratory) or "",
        ),
        language,
    )  # fmt: skip


def _side(days: int) -> str:
    return "before" if days < 0 else "after"


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


# Advice on the recalibration interval, by the reliability method on a unit's own history.
#
# The reliability method of NCSLI RP-1 and of ILAC-G24/OIML D 10: the probability that a unit is
# still within its limits after a time t is R(t) = exp(−λt), and the interval is that at whose end R
# is the target, t* = −ln R*/λ. A calibration finds whether the unit is within its limits, not
# since when it is not: each interval gives exp(−λt) or 1 − exp(−λt). What is known of λ is that
# likelihood over a flat prior on λ ≥ 0; without a failure its 95 % quantile is 3.0/Σt, the
# classical bound.


TARGET = 0.95  # of the units within their limits at the end of an interval
LEAST_INTERVALS = 3
POINTS = 200_001
TAIL = 60.0  # λ·Σt of the conforming intervals up to which the likelihood is worked out

Advice = Literal["too few", "keep", "shorten", "may be longer"]


@dataclass(frozen=True)
class Interval:
    """Days between two calibrations, and whether the second found the unit within its limits."""

    days: float
    conforming: bool


@dataclass(frozen=True)
class IntervalAdvice:
    """What the history says of an interval.

    days: t* at the median of λ; shortest, longest: at its 95 % and 5 % quantiles, so that t* lies
    between them with 90 % probability. None where the history does not say.
    """

    advice: Advice
    intervals: int
    conforming: int
    days: float | None = None
    shortest: float | None = None
    longest: float | None = None


def advise(history: Sequence[Interval], agreed_days: float) -> IntervalAdvice:
    """Advice on an agreed interval; it is changed only where the history contradicts it.

    Shorten: longer than the longest t* that the history allows. May be longer: shorter than the
    shortest. With fewer than three intervals, or none that conforms, no t* is given; none that
    conforms of three or more is reason enough to shorten.
    """
    conforming = sum(interval.conforming for interval in history)
    counts = {"intervals": len(history), "conforming": conforming}
    if len(history) < LEAST_INTERVALS:
        return IntervalAdvice("too few", **counts)
    if conforming == 0:
        return IntervalAdvice("shorten", **counts)
    low, middle, high = failure_rates(history, (0.05, 0.5, 0.95))
    shortest, days, longest = (-math.log(TARGET) / rate for rate in (high, middle, low))
    advice: Advice = "keep"
    if agreed_days > longest:
        advice = "shorten"
    elif agreed_days < shortest:
        advice = "may be longer"
    return IntervalAdvice(advice, **counts, days=days, shortest=shortest, longest=longest)


def failure_rates(
    history: Sequence[Interval], probabilities: tuple[float, ...]
) -> tuple[float, ...]:
    """Quantiles of λ (per day); at least one interval of the history conforms."""
    days = np.array([interval.days for interval in history], float)
    good = np.array([interval.conforming for interval in history], bool)
    rates = np.linspace(0.0, TAIL / days[good].sum(), POINTS)[1:]
    log = -rates * days[good].sum()
    for t in days[~good]:
        log = log + np.log(-np.expm1(-rates * t))
    density = np.exp(log - log.max())
    share = np.cumsum(density) / density.sum()
    return tuple(float(np.interp(p, share, rates)) for p in probabilities)
