"""Certificate numbers: a series counts up from 1, without gaps or duplicates."""

from collections.abc import Iterator

import sqlalchemy as sql

from storage.catalogue import database, tables
from storage.home import Home


class _Serial:
    """A placeholder in a scheme for a serial number that is not yet known."""

    def __format__(self, spec: str) -> str:
        return f"{{serial:{spec}}}"


def series_of(scheme: str, prefix: str, year: int) -> str:
    """A laboratory's scheme with prefix and year filled in, as `MIMU-2026-{serial:04d}`."""
    return scheme.format(prefix=prefix, year=year, serial=_Serial())


def next_number(connection: sql.Connection, series: str) -> str:
    """The next number of a series; others wait for the end of the transaction.

    The number is used up only when the transaction is committed.
    """
    table = tables.series
    insert = database.dialect(connection).insert(table).values(pattern=series, last=1, before=0)
    counted = insert.on_conflict_do_update(
        index_elements=[table.c.pattern], set_={"last": table.c.last + 1}
    )
    serial = connection.execute(counted.returning(table.c.last)).scalar_one()
    return series.format(serial=serial)


def missing(home: Home) -> Iterator[str]:
    """The numbers that were given and are not in the register."""
    given_by = database.rows(home, sql.select(tables.series))  # first: others may go on issuing
    held = {row.number for row in database.rows(home, sql.select(tables.certificates.c.number))}
    for series in given_by:
        given = range(series.before + 1, series.last + 1)
        numbers = (series.pattern.format(serial=serial) for serial in given)
        yield from (number for number in numbers if number not in held)
