"""Certificates issued at once, and issues that are killed: no gap, no double, nothing half."""

from collections.abc import Iterator

import pytest
import sqlalchemy as sql

from storage.catalogue import database, tables
from storage.home import Home
from tests import postgres
from tests.proof.issue import checked_drafts, faults_of, issue_at_once, kill_issues, left_over


@pytest.fixture
def on_postgres(fresh: Home, monkeypatch: pytest.MonkeyPatch) -> Iterator[Home]:
    with postgres.running() as server:
        monkeypatch.setenv("MIMUCAL_DATABASE", postgres.empty_database(server))
        yield fresh


@pytest.mark.rehearsal
def test_four_processes_issue_without_gap_and_without_double_on_postgresql(
    on_postgres: Home,
) -> None:
    done = issue_at_once(on_postgres, checked_drafts(on_postgres, 24), processes=4)
    assert done.faults == ()


def test_four_processes_issue_without_gap_and_without_double_on_sqlite(fresh: Home) -> None:
    assert issue_at_once(fresh, checked_drafts(fresh, 8), processes=4).faults == ()


@pytest.mark.rehearsal
def test_an_issue_that_is_killed_is_whole_or_did_not_happen(fresh: Home) -> None:
    killed = kill_issues(fresh, kills=10, seed=1)
    assert killed.faults == ()


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
