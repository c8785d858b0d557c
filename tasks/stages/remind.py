"""Stage: which units are due for recalibration, and messages to their clients."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from itertools import pairwise

from schemas.base import Unusable
from schemas.certificate import Party
from schemas.store import DueUnit, RecallFile
from schemas.text import text_of
from storage import settings
from storage.catalogue import certificates, equipment
from storage.catalogue.certificates import Entry
from storage.home import Home
from tasks.reminders import (
    OCCASIONS,
    Interval,
    IntervalAdvice,
    advise,
    body,
    calendar,
    check_channel,
    is_silent,
    occasion,
    pause,
    send,
    title,
)
from tasks.stages.stage import announce, logger_of
from tasks.words import MAIN, Message, Sayable, message, say, statement

REMIND_LOG = logger_of("remind")
Send = Callable[[str, str, str, bytes | None], str | None]


def due_units(home: Home, until: date = date.max) -> list[DueUnit]:
    """The units whose newest issued certificate falls due by a day, and whose order agreed on it.

    The longest overdue come first. What an earlier version issued may have a date that no order
    agreed on.
    """
    found = []
    for due in certificates.due(home, until):
        terms = certificates.terms_of(due, home)
        order, laboratory = terms.order, terms.laboratory
        if order and order.agrees_on_recalibration:
            party = laboratory.party if laboratory else None
            found.append(
                DueUnit(
                    unit=due.unit,
                    key=due.key,
                    model=due.model,
                    certificate=due.certificate,
                    issued_on=terms.issued_on,
                    due=due.due,
                    client=_names(order.client),
                    laboratory=_names(party),
                )
            )
    return found


def _names(party: Party | None) -> tuple[str, str]:
    named = text_of(party, "name") if party else None
    return (named or statement("")).pair


def remind(home: Home, now: datetime, send: Send = send) -> list[str]:
    """Sends the reminders that are due at a moment; returns those that failed, in a sentence each.

    Each reminder is sent once on each channel of its client. One that fails is tried again by a
    later call, after a pause that doubles from 5 minutes to 6 hours; in silent hours nothing is
    sent, and the next call after them sends it. Without recall.toml nothing is sent. Raises
    Unusable for an invalid channel.
    """
    asked = settings.reminders(home)
    if asked is None:
        return []
    urls = {
        (client.name, name): check_channel(name, url)
        for client in asked.clients
        for name, url in client.channels.items()
    }
    if is_silent(asked.silent, now):
        return []
    faults = []
    today = now.astimezone().date()
    for each in due_units(home, today - timedelta(days=OCCASIONS[0])):
        days = occasion(each.due, each.issued_on, today)
        client = next((client for client in asked.clients if client.name in each.client), None)
        if client is None or days is None:
            continue
        for name in client.channels:
            key = (each.certificate, days, f"{client.name} {name}")
            if equipment.claim(home, key, now, pause):
                url = urls[client.name, name]
                fault = _sent(send, url, each, days, client.language, now)
                equipment.note(home, key, now, fault)
                fields = {"of": each.certificate, "channel": key[2], "cause": fault}
                (REMIND_LOG.error if fault else REMIND_LOG.info)(
                    "failed" if fault else "sent", extra=fields
                )
                if fault:
                    announce("reminder.failed", each.unit, channel=key[2], why=fault)
                    faults.append(f"{each.unit} to {key[2]}: {fault}")
    return faults


def sent(home: Home) -> dict[str, list[str]]:
    """What was sent, by certificate: channel, occasion and day."""
    found: dict[str, list[str]] = {}
    for each in equipment.all_reminders(home):
        if each.sent_at is not None:
            day = each.sent_at.astimezone().date().isoformat()
            line = f"{each.channel}, {abs(each.days)} days {_side(each.days)}, {day}"
            found.setdefault(each.certificate, []).append(line)
    return found


def feed(home: Home, name: str, now: datetime) -> bytes:
    """The calendar of a client: every due date of its units.

    Raises Unusable for a client whom neither recall.toml nor any certificate names.
    """
    asked = settings.reminders(home) or RecallFile()
    every = due_units(home)
    client = next((client for client in asked.clients if client.name == name), None)
    own = [each for each in every if name in each.client]
    if client is None and not own:
        raise Unusable(
            f"No client {name!r} stands in recall.toml or on an issued certificate with an agreed "
            "interval; give the name as the orders have it."
        )
    return calendar(own, client.language if client else MAIN, now)


def _sent(
    send: Send, url: str, due_unit: DueUnit, days: int, language: str, now: datetime
) -> str | None:
    entry = calendar([due_unit], language, now, OCCASIONS.index(days))
    return send(url, title(due_unit, days, language), body(due_unit, days, language), entry)


def _side(days: int) -> str:
    return "before" if days < 0 else "after"


class NoAdvice(Unusable):
    """Certificates that say nothing of an interval."""

    def __init__(self, why: Message) -> None:
        super().__init__(say(why))
        self.why = why


def interval_advice(serial: str, home: Home) -> tuple[str, int, IntervalAdvice]:
    """The unit, its agreed interval in days, and the advice on it.

    Raises NoAdvice for a serial number without such a certificate, of several products, or
    whose last certificate has no agreed date.
    """
    entries = [entry for entry in certificates.register(home) if entry.serial == serial]
    return advice_by(entries, serial, home)


def advice_by(of_unit: Sequence[Entry], serial: str, home: Home) -> tuple[str, int, IntervalAdvice]:
    """The same by the certificates of a unit.

    Counted are the intervals between issued certificates whose day of calibration is known; as
    found, where the unit was adjusted. Inconclusive verdicts say nothing about the interval.
    """
    entries = [entry for entry in of_unit if entry.state == "issued" and entry.calibrated_on]
    units = {f"{entry.manufacturer} {entry.model} {entry.serial}" for entry in entries}
    if len(units) != 1:
        kind = "several" if units else "none"
        raise NoAdvice(
            message(f"reminder-no-advice.{kind}", serial=serial, units=tuple(sorted(units)))
        )
    dated = sorted(entries, key=_day)
    verdicts = [_verdict_found(entry, home) for entry in dated]
    history = [
        Interval((_day(later) - _day(earlier)).days, verdict == "pass")
        for (earlier, later), verdict in zip(pairwise(dated), verdicts[1:], strict=True)
        if verdict != "inconclusive" and _day(later) > _day(earlier)
    ]
    last = dated[-1]
    if last.due is None:
        raise NoAdvice(message("reminder-no-advice.not-agreed", certificate=last.number))
    agreed = (last.due - _day(last)).days
    return units.pop(), agreed, advise(history, agreed)


def sentence(unit: str, agreed: int, advice: IntervalAdvice) -> Message:
    """The advice in words."""
    known = advice.days is not None
    return message(
        f"reminder-advice.{advice.advice.replace(' ', '-')}{'' if known else '-unknown'}",
        unit=unit, agreed=str(agreed), intervals=str(advice.intervals),
        conforming=str(advice.conforming), days=f"{advice.days or 0:.0f}",
        shortest=f"{advice.shortest or 0:.0f}", longest=f"{advice.longest or 0:.0f}",
    )  # fmt: skip


def _day(entry: Entry) -> date:
    assert entry.calibrated_on is not None
    return entry.calibrated_on


def _verdict_found(entry: Entry, home: Home) -> str:
    """The verdict on the unit as it came."""
    if not certificates.may_be_as_left(entry):
        return entry.verdict
    record = certificates.record_of(entry, home)
    return (record.as_found or record).decision.verdict


# Stage: a sentence to whoever operates the line, by the channels of recall.toml.

ALERT_LOG = logger_of("alert")


@dataclass(frozen=True)
class Sent:
    """The outcome of an alert on a channel; fault: why it was not delivered, None if it was."""

    channel: str
    fault: str | None


def alert(
    home: Home,
    sentence: Sayable,
    send: Send = send,
    *,
    only: Collection[str] | None = None,
) -> list[Sent]:
    """Sends a sentence to the operators on each of their channels, in silent hours too.

    only: the channels, by name, in the place of all.

    Raises Unusable where recall.toml names no operators, and for an invalid channel.
    """
    asked = settings.reminders(home)
    if asked is None or asked.operators is None:
        raise Unusable(
            f"{home.path / settings.REMINDERS} names no operators; add [operators] with channels."
        )
    urls = {
        name: check_channel(name, url)
        for name, url in asked.operators.channels.items()
        if only is None or name in only
    }
    language = asked.operators.language
    title, sentence = say(message("alert-title"), language), say(sentence, language)
    done = [Sent(name, send(url, title, sentence, None)) for name, url in urls.items()]
    for each in done:
        fields = {"of": sentence, "channel": each.channel, "cause": each.fault}
        ALERT_LOG.warning("failed" if each.fault else "sent", extra=fields)
    return done
