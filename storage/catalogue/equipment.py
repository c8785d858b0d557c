"""The register of measurement standards: each with all of its certificates."""

import json
from collections.abc import Callable, Iterable
from datetime import UTC, date, datetime, timedelta

import sqlalchemy as sql

from schemas.base import Frozen, Unusable
from schemas.laboratory import IntermediateCheck, MeasurementStandard
from storage.catalogue import audit_trail, database, tables
from storage.home import Home


def add(standards: Iterable[MeasurementStandard], home: Home, person: str) -> None:
    """Adds standards to the register, all or none; raises Unusable for one already there."""
    with database.changing(home) as connection:
        for standard in standards:
            if known := _certificates(connection, standard.serial):
                raise Unusable(
                    f"{standard.name} ({standard.serial}) is already in the register, with "
                    f"certificate {known[-1]}; `mimucal equipment renew` adds a new certificate."
                )
            _insert(connection, standard)
            _note(connection, person, "add equipment", standard)


def renew(standards: Iterable[MeasurementStandard], home: Home, person: str) -> None:
    """Adds a new certificate for each standard, all or none; the earlier ones stay.

    Raises Unusable for a standard that is not in the register, one without a day of calibration,
    and a certificate that is already there.
    """
    with database.changing(home) as connection:
        for standard in standards:
            named = f"{standard.name} ({standard.serial})"
            known = _certificates(connection, standard.serial)
            if not known:
                raise Unusable(
                    f"{named} is not in the register; add it with `mimucal equipment add`."
                )
            if standard.certificate in known:
                raise Unusable(
                    f"certificate {standard.certificate} of {named} is already in the register; "
                    "give the new one."
                )
            if standard.calibrated_on is None:
                raise Unusable(
                    f"{named} has no calibrated_on, the day from which its new certificate counts."
                )
            _insert(connection, standard)
            _note(connection, person, "renew equipment", standard)


def add_check(
    serial: str, check: IntermediateCheck, home: Home, person: str
) -> MeasurementStandard:
    """Adds an intermediate check to the certificate of its day, which is returned.

    Raises Unusable for a standard that is not in the register.
    """
    table = tables.standards
    with database.changing(home) as connection:
        asked = sql.select(table.c.document).where(table.c.serial == serial)
        known = [_standard(row.document) for row in connection.execute(asked.with_for_update())]
        if not known:
            raise Unusable(
                f"{serial} is not in the register; add it with `mimucal equipment add`, or see "
                "`mimucal equipment list`."
            )
        standard = _of_day(known, check.checked_on)[serial]
        checked = standard.model_copy(update={"checks": (*standard.checks, check)})
        connection.execute(
            sql.update(table)
            .where(table.c.serial == serial, table.c.certificate == standard.certificate)
            .values(document=checked.model_dump_json())
        )
        audit_trail.add(
            connection, person, "check equipment", serial,
            certificate=standard.certificate, check=check.model_dump(mode="json"),
        )  # fmt: skip
    return checked


def register(home: Home) -> list[MeasurementStandard]:
    """Every certificate of every standard: by serial number, then from the oldest."""
    table = tables.standards.c
    asked = sql.select(table.document).order_by(table.serial, table.added_at, table.certificate)
    found = [_standard(row.document) for row in database.rows(home, asked)]
    return sorted(found, key=lambda each: (each.serial, each.calibrated_on or date.min))


def on_day(home: Home, day: date | None) -> dict[str, MeasurementStandard]:
    """The standards by serial number, each with the certificate that was valid on a day.

    This is the last one from before the day, or else the first of all. None: the last one.
    """
    return _of_day(register(home), day)


def _of_day(
    standards: Iterable[MeasurementStandard], day: date | None
) -> dict[str, MeasurementStandard]:
    """By serial number, of the certificates of each in the order of their days."""
    found: dict[str, MeasurementStandard] = {}
    for standard in sorted(standards, key=lambda each: each.calibrated_on or date.min):
        began = standard.calibrated_on or date.min
        if standard.serial not in found or day is None or began <= day:
            found[standard.serial] = standard
    return found


def past_due(home: Home, day: date) -> list[MeasurementStandard]:
    """The standards of the register that had no valid certificate on a day."""
    return [
        standard
        for standard in on_day(home, day).values()
        if standard.valid_until and standard.valid_until < day
    ]


def _certificates(connection: sql.Connection, serial: str) -> list[str]:
    table = tables.standards.c
    asked = sql.select(table.certificate).where(table.serial == serial).order_by(table.added_at)
    return list(connection.scalars(asked))


def _insert(connection: sql.Connection, standard: MeasurementStandard) -> None:
    connection.execute(
        sql.insert(tables.standards).values(
            serial=standard.serial,
            certificate=standard.certificate,
            name=standard.name,
            calibrated_on=standard.calibrated_on,
            valid_until=standard.valid_until,
            added_at=datetime.now(UTC),
            document=standard.model_dump_json(),
        )
    )


def _note(
    connection: sql.Connection, person: str, action: str, standard: MeasurementStandard
) -> None:
    audit_trail.add(
        connection, person, action, standard.serial,
        certificate=standard.certificate, valid_until=str(standard.valid_until),
    )  # fmt: skip


def _standard(document: str) -> MeasurementStandard:
    return MeasurementStandard.model_validate(json.loads(document))


# Which reminders were sent, and when the others will be tried again.
#
# A reminder is a certificate, an occasion (days after the due date) and a channel.


class Reminder(Frozen):
    """The state of a reminder; sent_at: null until it is sent; fault: of the last attempt."""

    certificate: str
    days: int
    channel: str
    tries: int
    next_try_at: datetime
    sent_at: datetime | None
    fault: str | None


def claim(
    home: Home,
    key: tuple[str, int, str],
    now: datetime,
    pause: Callable[[int], timedelta],
) -> bool:
    """Whether the caller is to send a reminder now: it was not sent, and no attempt is too recent.

    Of several processes that ask at once only one gets it. If that one dies before sending, another
    gets it after the pause.
    """
    table = tables.reminders
    certificate, days, channel = key
    with database.changing(home) as connection:
        database.add_new(
            connection, table, certificate=certificate, days=days, channel=channel,
            tries=0, next_try_at=now,
        )  # fmt: skip
        this = _is(key)
        row = connection.execute(sql.select(table).where(this).with_for_update()).one()
        if row.sent_at is not None or row.next_try_at > now:
            return False
        tries = row.tries + 1
        connection.execute(
            sql.update(table).where(this).values(tries=tries, next_try_at=now + pause(tries))
        )
        return True


def note(home: Home, key: tuple[str, int, str], now: datetime, fault: str | None) -> None:
    """Records that a reminder was sent, or why not."""
    sent_at = now if fault is None else None
    with database.changing(home) as connection:
        connection.execute(
            sql.update(tables.reminders).where(_is(key)).values(sent_at=sent_at, fault=fault)
        )


def all_reminders(home: Home) -> list[Reminder]:
    """Every reminder that was ever attempted, ordered by occasion."""
    table = tables.reminders
    asked = sql.select(table).order_by(table.c.certificate, table.c.days, table.c.channel)
    found = database.rows(home, asked)
    return [Reminder.model_validate(row, from_attributes=True) for row in found]


def _is(key: tuple[str, int, str]) -> sql.ColumnElement[bool]:
    table = tables.reminders.c
    certificate, days, channel = key
    return sql.and_(table.certificate == certificate, table.days == days, table.channel == channel)
