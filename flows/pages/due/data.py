"""Reads what is due from the catalogue, by the functions that send the reminders."""

from collections import Counter
from collections.abc import Sequence
from datetime import date, timedelta

from dateutil.relativedelta import relativedelta

from flows.pages.due.models import (
    ClientDue,
    DueQuestion,
    DueShown,
    MessageShown,
    MessageState,
    Month,
    StandardDue,
    UnitDue,
)
from flows.pages.local_time import today
from flows.pages.states import StepState, stated
from schemas.recall import DueUnit
from storage.catalogue import equipment, reminders
from storage.catalogue.reminders import Reminder
from storage.home import Home
from tasks.conformity.equipment import name_of
from tasks.stages import remind
from tasks.words import statement

SOON = timedelta(days=90)
MONTHS = 12
LAST_MESSAGES = 500


def data(question: DueQuestion, home: Home) -> DueShown:
    """Units, messages and equipment of a question; raises Unusable for a damaged certificate."""
    now, every = today(), remind.due_units(home)
    of = [each for each in every if _is_asked(each, question)]
    messages = reminders.all_reminders(home)
    sent = Counter(each.certificate for each in messages if each.sent_at is not None)
    if question.client is not None or question.model is not None:
        theirs = {each.certificate for each in of}
        messages = [each for each in messages if each.certificate in theirs]
    until = now + timedelta(days=question.within)
    return DueShown(
        today=now,
        units=tuple(_unit(each, now, sent) for each in of if each.due <= until),
        by_client=tuple(_clients(of, now, until)),
        months=tuple(_months(of, now)),
        messages=tuple(sorted(map(_message, messages), key=_at, reverse=True)[:LAST_MESSAGES]),
        equipment=tuple(_equipment(home, now)),
        clients=tuple(sorted({each.client for each in every})),
        models=tuple(sorted({each.model for each in every})),
    )


def _is_asked(due_unit: DueUnit, question: DueQuestion) -> bool:
    is_client = question.client is None or question.client in due_unit.client
    return is_client and question.model in (None, due_unit.model)


def _unit(due_unit: DueUnit, now: date, sent: Counter[str]) -> UnitDue:
    return UnitDue(
        unit=due_unit.key, name=due_unit.unit, model=due_unit.model, client=due_unit.client,
        certificate=due_unit.certificate, due=due_unit.due, days=(due_unit.due - now).days,
        messages=sent[due_unit.certificate],
    )  # fmt: skip


def _clients(of: Sequence[DueUnit], now: date, until: date) -> list[ClientDue]:
    overdue = Counter(each.client for each in of if each.due < now)
    coming = Counter(each.client for each in of if now <= each.due <= until)
    return [
        ClientDue(client=client, overdue=overdue[client], coming=coming[client])
        for client in sorted(overdue | coming)
    ]


def _months(of: Sequence[DueUnit], now: date) -> list[Month]:
    """What falls due from today on in this month and in those after it."""
    counts = Counter(f"{each.due:%Y-%m}" for each in of if each.due >= now)
    first = now.replace(day=1)
    names = [f"{first + relativedelta(months=number):%Y-%m}" for number in range(MONTHS)]
    return [Month(month=name, units=counts[name]) for name in names]


def _message(reminder: Reminder) -> MessageShown:
    state: MessageState = "sent" if reminder.sent_at else "failed" if reminder.fault else "waiting"
    return MessageShown(
        certificate=reminder.certificate, days=reminder.days, channel=reminder.channel,
        state=state, at=reminder.sent_at or reminder.next_try_at, tries=reminder.tries,
        fault=reminder.fault,
    )  # fmt: skip


def _at(shown: MessageShown) -> tuple[float, str]:
    return shown.at.timestamp(), shown.certificate


def _equipment(home: Home, now: date) -> list[StandardDue]:
    """Each standard with the certificate that counts now, the first that falls due first."""
    counted = [
        StandardDue(
            serial=each.serial, name=statement(name_of(each)), certificate=each.certificate,
            valid_until=each.valid_until,
            days=(each.valid_until - now).days if each.valid_until else None,
        )
        for each in equipment.on_day(home, now).values()
    ]  # fmt: skip
    return sorted(counted, key=lambda each: (each.valid_until or date.max, each.serial))


def due_state(due: date | None, day: date | None = None) -> StepState:
    """Overdue is bad, and what falls due within 90 days is open. day: the present one."""
    now = day or today()
    if due is None:
        return stated("pages-due-state.none", "none")
    if due < now:
        return stated("pages-due-state.overdue", "bad", days=(now - due).days)
    days = (due - now).days
    return stated("pages-due-state.in", "open" if due <= now + SOON else "good", days=days)
