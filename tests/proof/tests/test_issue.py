"""Certificates issued at once, and issues that are killed: no gap, no double, nothing half."""

import sqlalchemy as sql

from storage.catalogue import database, tables
from storage.home import Home
from tests.proof.issue import checked_drafts, faults_of, issue_at_once, left_over


def test_four_processes_issue_without_gap_and_without_double_on_sqlite(fresh: Home) -> None:
    assert issue_at_once(fresh, checked_drafts(fresh, 8), processes=4).faults == ()


def test_the_judge_notices_a_gap_a_double_and_a_file_that_is_gone(fresh: Home) -> None:
    keys = checked_drafts(fresh, 3)
    assert issue_at_once(fresh, keys, processes=1).faults == ()
    with database.changing(fresh) as connection:
        connection.execute(sql.delete(tables.decisions))
        third = tables.certificates.c.number.endswith("-0003")
        connection.execute(
            sql.update(tables.certificates)
            .where(third)
            .values(draft=keys[0], number="LAB-2026-0004")
        )
    faults = faults_of(fresh, keys)
    assert any("serial numbers [1, 2, 4]" in fault for fault in faults)
    assert "a draft was issued twice, or not at all" in faults
    next(fresh.certificates.glob("*-0001.pdf")).unlink()
    assert len(faults_of(fresh, keys)) == len(faults) + 1
    (fresh.certificates / "LAB-2026-0009.pdf").touch()
    assert "LAB-2026-0009.pdf" in left_over(fresh)
