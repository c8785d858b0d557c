"""Results: kept once, never overwritten, each superseding the one before and saying why."""

from collections.abc import Callable
from datetime import UTC, date, datetime

import pytest
import sqlalchemy as sql

from schemas.base import Unusable
from schemas.calibration import AdoptedTerm
from schemas.orders import Selection
from storage import dataframes, verify
from storage.catalogue import certificates, database, equipment, results, runs, tables
from storage.catalogue.database import version
from storage.catalogue.selection import impact_of, select
from storage.home import Home
from tests import postgres
from tests.keep import keep, take_number
from tests.storage.small import calibrated, certified, small


def test_result_comes_back_as_it_went_in(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    assert results.of_run(run, fresh) == []
    results.save(calibrated(run), fresh)
    (kept,) = results.of_run(run, fresh)
    assert kept.calibration == calibrated(run)


def test_new_result_supersedes_the_older_and_says_why(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    one = results.save(calibrated(run), fresh)
    two = results.save(calibrated(run, 0.5, code_version="2"), fresh)
    three = results.save(calibrated(run, 0.75, code_version="2"), fresh, why="table was off")
    four = results.save(calibrated(run, 0.5, code_version="2"), fresh)
    kept = results.of_run(run, fresh)
    assert [result.id for result in kept] == [one, two, three, four]
    assert [result.supersedes for result in kept] == [None, one, two, three]
    assert [result.why for result in kept] == [
        None,
        "made with another code_version (1 to 2)",
        "table was off",
        "other values, made the same",
    ]
    assert kept[3].calibration == kept[1].calibration


def test_methods_do_not_supersede_each_other(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    results.save(calibrated(run), fresh)
    results.save(calibrated(run, 0.5, method="joint"), fresh)
    assert [result.supersedes for result in results.of_run(run, fresh)] == [None, None]


def test_a_result_with_further_terms_stands_beside_the_one_without(fresh: Home) -> None:
    """Each line of results goes on by itself, whichever was kept last."""
    run = runs.add(small(), fresh)[0]
    arm, tilt = (AdoptedTerm(name=name, title="t", title_zh="t") for name in ("arm", "tilt"))
    plain = results.save(calibrated(run), fresh)
    armed = results.save(calibrated(run, 0.5, terms=(arm,)), fresh)
    both = results.save(calibrated(run, 0.5, terms=(arm, tilt)), fresh)
    assert results.save(calibrated(run), fresh) == plain
    later = results.save(calibrated(run, 0.7, terms=(arm,)), fresh)
    kept = {result.id: result.supersedes for result in results.of_run(run, fresh)}
    assert kept == {plain: None, armed: None, both: None, later: armed}
    newest = results.newest(results.of_run(run, fresh))
    assert newest is not None
    assert newest.id == results.find(run.id, fresh).id == plain
    table = dataframes.results(fresh).groupby("result")["terms"].first()
    assert dict(table) == {plain: "", armed: "arm", both: "arm tilt", later: "arm"}


def test_a_result_is_found_by_its_id(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    kept = results.save(calibrated(run, 0.5), fresh)
    assert results.find(kept, fresh).calibration == calibrated(run, 0.5)
    with pytest.raises(Unusable, match="no result 'c0'"):
        results.find("c0", fresh)


def test_result_of_a_run_that_is_not_kept_is_refused(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    for stranger in ({"run": "r0"}, {"digest": "0" * 64}):
        with pytest.raises(Unusable, match="import the recording first"):
            results.save(calibrated(run).model_copy(update=stranger), fresh)


def test_results_saved_at_once_form_one_line(
    either: Home, at_once: Callable[..., list[str]]
) -> None:
    run = runs.add(small(), either)[0]
    script = """
import os
from schemas.calibration import AdoptedTerm, Calibration
document = Calibration.model_validate_json(arguments[0])
print(results.save(document.model_copy(update={"code_version": str(os.getpid())}), home))
"""
    at_once(script, either, calibrated(run).model_dump_json(), processes=3)
    kept = results.of_run(run, either)
    assert [result.supersedes for result in kept] == [None, kept[0].id, kept[1].id]


def test_document_that_cannot_be_read_is_named_and_can_be_superseded(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    one = results.save(calibrated(run), fresh)
    with database.changing(fresh) as connection:
        connection.execute(sql.update(tables.results).values(document="{}"))
    with pytest.raises(Unusable, match=f"result {one} cannot be read"):
        results.of_run(run, fresh)
    assert results.save(calibrated(run), fresh) != one


# What a real PostgreSQL does by itself; what it does like SQLite stands beside that.

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
    assert runs.all_runs(shared_catalogue) == []
    assert not shared_catalogue.path.exists()


def test_store_works_the_same_on_postgresql(shared_catalogue: Home) -> None:
    home, recording = shared_catalogue, small()
    run = runs.add(recording, home)[0]
    assert runs.add(recording, home)[0] == run == runs.find(run.id[:4], home)
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
from storage.catalogue import equipment as reminders
from tasks.reminders import pause
print(reminders.claim(home, ("A-1", -30, "mail"), datetime(2027, 1, 1, tzinfo=UTC), pause))
"""
    claims = at_once(script, shared_catalogue, processes=4)
    assert sorted(claim.strip() for claim in claims) == ["False", "False", "False", "True"]
    (kept,) = equipment.all_reminders(shared_catalogue)
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
    (waiting,) = results.to_make([run], "now", shared_catalogue)
    results.keep_fault(waiting, "the bucket was off", "now", 1.0, shared_catalogue)
    results.keep(waiting, calibrated(run, 0.5), "now", 1.0, shared_catalogue)
    (made,) = results.made_under("now", shared_catalogue)
    assert (made.before, made.fault) == (before, None)
    assert results.to_make([run], "now", shared_catalogue) == []
    table = dataframes.results(shared_catalogue)
    assert list(table.loc[table["newest"], "value"].dropna()) == [0.5]
    assert len(impact_of(Selection(equipment="T1"), shared_catalogue).results) == 2
