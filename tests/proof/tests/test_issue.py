"""Certificates issued at once: no gap, no double, nothing half; and a judge that would see them."""

import sqlalchemy as sql

from storage.catalogue import database, tables
from storage.home import Home
from tests.proof.issue import checked_drafts, faults_of, issue_at_once


def test_two_processes_issue_without_gap_double_or_file_left_over(fresh: Home) -> None:
    keys = checked_drafts(fresh, 4)
    assert issue_at_once(fresh, keys, processes=2).faults == ()
    with database.changing(fresh) as connection:
        connection.execute(sql.delete(tables.decisions))
        fourth = tables.certificates.c.number.endswith("-0004")
        changed = sql.update(tables.certificates).where(fourth)
        connection.execute(changed.values(draft=keys[0], number="LAB-2026-0005"))
    faults = faults_of(fresh, keys)
    assert any("serial numbers [1, 2, 3, 5]" in fault for fault in faults)
    assert "a draft was issued twice, or not at all" in faults
    next(fresh.certificates.glob("*-0001.pdf")).unlink()
    assert len(faults_of(fresh, keys)) == len(faults) + 1
    (fresh.certificates / "LAB-2026-0009.pdf").touch()
    assert "LAB-2026-0009.pdf was left over" in faults_of(fresh, keys)
