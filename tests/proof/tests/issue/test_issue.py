"""Certificates issued at once, and issues that are killed: no gap, no double, nothing half."""

from collections.abc import Iterator
from pathlib import Path

import pytest
import sqlalchemy as sql

from storage.catalogue import database, tables
from storage.home import Home
from tests import postgres
from tests.proof.issue.at_once import checked_drafts, faults_of, issue_at_once, left_over
from tests.proof.issue.kills import kill_issues


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Home:
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    return Home(tmp_path / "home")


@pytest.fixture
def on_postgres(home: Home, monkeypatch: pytest.MonkeyPatch) -> Iterator[Home]:
    with postgres.running() as server:
        monkeypatch.setenv("MIMUCAL_DATABASE", postgres.empty_database(server))
        yield home


@pytest.mark.rehearsal
def test_four_processes_issue_without_gap_and_without_double_on_postgresql(
    on_postgres: Home,
) -> None:
    done = issue_at_once(on_postgres, checked_drafts(on_postgres, 24), processes=4)
    assert done.faults == ()


def test_four_processes_issue_without_gap_and_without_double_on_sqlite(home: Home) -> None:
    assert issue_at_once(home, checked_drafts(home, 8), processes=4).faults == ()


@pytest.mark.rehearsal
def test_an_issue_that_is_killed_is_whole_or_did_not_happen(home: Home) -> None:
    killed = kill_issues(home, kills=10, seed=1)
    assert killed.faults == ()


def test_the_judge_notices_a_gap_a_double_and_a_file_that_is_gone(home: Home) -> None:
    keys = checked_drafts(home, 3)
    assert issue_at_once(home, keys, processes=1).faults == ()
    with database.changing(home) as connection:
        connection.execute(sql.delete(tables.decisions))
        third = tables.certificates.c.number.endswith("-0003")
        connection.execute(
            sql.update(tables.certificates)
            .where(third)
            .values(draft=keys[0], number="LAB-2026-0004")
        )
    faults = faults_of(home, keys)
    assert any("serial numbers [1, 2, 4]" in fault for fault in faults)
    assert "a draft was issued twice, or not at all" in faults
    next(home.certificates.glob("*-0001.pdf")).unlink()
    assert len(faults_of(home, keys)) == len(faults) + 1
    (home.certificates / "LAB-2026-0009.pdf").touch()
    assert "LAB-2026-0009.pdf" in left_over(home)
