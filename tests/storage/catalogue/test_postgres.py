"""What a real PostgreSQL does by itself; what it does like SQLite stands beside that."""

from collections.abc import Callable
from datetime import UTC, date, datetime

import pytest

from schemas.orders import Selection
from storage import dataframes, verify
from storage.catalogue import (
    certificates,
    database,
    reminders,
    reprocessing,
    results,
    run_index,
    runs,
    tables,
)
from storage.catalogue.selection import impact_of, select
from storage.catalogue.unchanged import version
from storage.home import Home
from tests import postgres
from tests.keep import keep, take_number
from tests.storage.small import calibrated, certified, small

AtOnce = Callable[..., list[str]]


@pytest.fixture
def shared_catalogue(server: str, fresh: Home, monkeypatch: pytest.MonkeyPatch) -> Home:
    """A fresh home whose catalogue is an empty database of its own."""
    monkeypatch.setenv("MIMUCAL_DATABASE", postgres.empty_database(server))
    return fresh


def test_a_commit_gives_the_catalogue_another_version(shared_catalogue: Home) -> None:
    before = version(shared_catalogue)
    assert version(shared_catalogue) == before
    with database.changing(shared_catalogue) as connection:
        connection.execute(tables.series.insert().values(pattern="P", last=1, before=0))
    assert version(shared_catalogue) != before


def test_looking_makes_no_folder_with_postgresql(shared_catalogue: Home) -> None:
    assert run_index.all_runs(shared_catalogue) == []
    assert not shared_catalogue.path.exists()


def test_store_works_the_same_on_postgresql(shared_catalogue: Home) -> None:
    home, recording = shared_catalogue, small()
    run = runs.add(recording, home)[0]
    assert runs.add(recording, home)[0] == run == run_index.find(run.id[:4], home)
    results.save(calibrated(run), home)
    results.save(calibrated(run, 0.5), home)
    assert [result.why for result in results.of_run(run, home)] == [
        None,
        "other values, made the same",
    ]
    number = take_number(home)
    certificate = certified(recording, calibrated(run, 0.5), number)
    keep(certificate, home)
    assert certificates.find(number, home) == certificate
    assert [line.certificate for line in certificates.due(home, date(2030, 1, 1))] == [number]
    assert verify.verify(home) == (11, [])
    assert not (home.path / "catalog.sqlite").exists()


def test_a_reminder_asked_for_at_once_on_postgresql_is_sent_by_one(
    shared_catalogue: Home, at_once: AtOnce
) -> None:
    recording = small()
    run = runs.add(recording, shared_catalogue)[0]
    results.save(calibrated(run), shared_catalogue)
    keep(certified(recording, calibrated(run), "A-1"), shared_catalogue)
    script = """
from datetime import UTC, datetime
from storage.catalogue import reminders
from tasks.reminders.send import pause
print(reminders.claim(home, ("A-1", -30, "mail"), datetime(2027, 1, 1, tzinfo=UTC), pause))
"""
    claims = at_once(script, shared_catalogue, processes=4)
    assert sorted(claim.strip() for claim in claims) == ["False", "False", "False", "True"]
    (kept,) = reminders.all_reminders(shared_catalogue)
    assert (kept.tries, kept.sent_at) == (1, None)


def test_a_row_says_whether_it_is_new_on_postgresql(shared_catalogue: Home) -> None:
    values = {"nonce": "n", "taken_at": datetime.now(UTC)}
    with database.changing(shared_catalogue) as connection:
        new = [database.add_new(connection, tables.signatures, **values) for _ in range(2)]
    assert new == [True, False]


def test_history_is_made_again_and_asked_for_as_in_sqlite(shared_catalogue: Home) -> None:
    run = runs.add(small(), shared_catalogue)[0]
    before = results.save(calibrated(run, code_version="0.1.0+a"), shared_catalogue)
    chosen = Selection(station="T1", code_version="0.1.0", since=run.imported_at.date())
    assert [each.id for each in select(chosen, shared_catalogue)] == [run.id]
    (waiting,) = reprocessing.to_make([run], "now", shared_catalogue)
    reprocessing.keep_fault(waiting, "the bucket was off", "now", 1.0, shared_catalogue)
    reprocessing.keep(waiting, calibrated(run, 0.5), "now", 1.0, shared_catalogue)
    (made,) = reprocessing.made_under("now", shared_catalogue)
    assert (made.before, made.fault) == (before, None)
    assert reprocessing.to_make([run], "now", shared_catalogue) == []
    table = dataframes.results(shared_catalogue)
    assert list(table.loc[table["newest"], "value"].dropna()) == [0.5]
    assert len(impact_of(Selection(equipment="T1"), shared_catalogue).results) == 2
