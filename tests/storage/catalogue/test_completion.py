"""What an earlier version kept gets the rows that certificates have today."""

from pathlib import Path

import sqlalchemy as sql

from storage.catalogue import database, tables
from storage.catalogue.completion import complete_certificates
from storage.home import Home
from tests.drafts import draft


def decisions(home: Home) -> list[tuple]:
    return [tuple(row) for row in database.rows(home, sql.select(tables.decisions))]


def test_what_a_certificate_decides_is_kept_with_it_and_filled_in_from_its_record(
    tmp_path: Path,
) -> None:
    home = Home(tmp_path)
    draft(home, "1")
    kept = decisions(home)
    (row,) = kept
    assert row[2:] == ("gyro_bias", "x", "value", -1.0, 1.0, "pass")
    with database.changing(home) as connection:
        connection.execute(sql.delete(tables.decisions))
        connection.execute(sql.update(tables.certificates).values(limits=None))
    complete_certificates(home)
    assert decisions(home) == kept
    draft(home, "1")  # in the place of the one before
    assert len(decisions(home)) == 1


def test_a_record_that_cannot_be_read_is_left_out(tmp_path: Path) -> None:
    home = Home(tmp_path)
    draft(home, "1")
    with database.changing(home) as connection:
        connection.execute(sql.delete(tables.decisions))
        connection.execute(sql.update(tables.certificates).values(limits=None, record="none"))
    complete_certificates(home)
    assert decisions(home) == []
