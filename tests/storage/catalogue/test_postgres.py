"""The catalogue on a real PostgreSQL, which it starts itself."""

from collections.abc import Callable, Iterator
from datetime import UTC, date, datetime
from itertools import chain
from pathlib import Path

import pytest
import sqlalchemy as sql
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.certificate import Certificate
from schemas.equipment import MeasurementStandard
from schemas.orders import Selection
from schemas.recording import Recording
from storage import dataframes, verify
from storage.catalogue import (
    certificates,
    database,
    equipment,
    orders,
    reminders,
    reprocessing,
    results,
    run_index,
    runs,
    tables,
    trail,
)
from storage.catalogue.connection import engine_of, url_of
from storage.catalogue.selection import impact_of, select
from storage.catalogue.unchanged import version
from storage.formats.columns import write_columns
from storage.home import Home
from tests import postgres
from tests.keep import keep, take_number
from tests.storage.catalogue.test_orders import CLAIM, order

Build = Callable[..., Recording]
AtOnce = Callable[..., list[str]]


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    """The connection of a PostgreSQL."""
    with postgres.running() as connection:
        yield connection


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


def test_migrations_and_tables_do_not_drift_on_postgresql(shared_catalogue: Home) -> None:
    with database.changing(shared_catalogue) as connection:
        assert connection.dialect.name == "postgresql"
        context = MigrationContext.configure(connection, opts={"compare_server_default": True})
        assert compare_metadata(context, tables.metadata) == []


def test_looking_makes_no_folder_with_postgresql(shared_catalogue: Home) -> None:
    assert run_index.all_runs(shared_catalogue) == []
    assert not shared_catalogue.path.exists()


def test_store_works_the_same_on_postgresql(
    shared_catalogue: Home,
    small: Build,
    calibrated: Callable[..., Calibration],
    certified: Callable[..., Certificate],
) -> None:
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


def test_concurrent_imports_on_postgresql_are_one_run(
    shared_catalogue: Home, small: Build, tmp_path: Path, at_once: AtOnce
) -> None:
    write_columns(small(), tmp_path / "source")
    script = """
path = Path(arguments[0])
print(runs.add(recordings.read(path), home, source=path)[0].id)
"""
    printed = at_once(script, shared_catalogue, str(tmp_path / "source"), processes=3)
    (run,) = run_index.all_runs(shared_catalogue)
    assert printed == [f"{run.id}\n"] * 3


def test_numbers_taken_at_once_on_postgresql_are_never_the_same(
    shared_catalogue: Home, at_once: AtOnce
) -> None:
    script = "from tests.keep import take_number\nprint(*[take_number(home) for _ in range(10)])"
    given = at_once(script, shared_catalogue, processes=3, has_catalogue=False)
    numbers = " ".join(given).split()
    assert sorted(numbers) == [f"MIMU-2026-{n:04d}" for n in range(1, 31)]


def test_a_reminder_asked_for_at_once_on_postgresql_is_sent_by_one(
    shared_catalogue: Home,
    small: Build,
    calibrated: Callable[..., Calibration],
    certified: Callable[..., Certificate],
    at_once: AtOnce,
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


def test_the_register_of_equipment_is_the_same_on_postgresql(shared_catalogue: Home) -> None:
    first = MeasurementStandard(
        name="Table", name_zh="台", serial="T-1", accuracy="", certificate="C-1",
        valid_until=date(2026, 2, 28),
    )  # fmt: skip
    second = first.model_copy(update={"certificate": "C-2", "calibrated_on": date(2026, 3, 1),
                                      "valid_until": date(2027, 2, 28)})  # fmt: skip
    equipment.add([first], shared_catalogue, "Li")
    equipment.renew([second], shared_catalogue, "Li")
    assert equipment.register(shared_catalogue) == [first, second]
    assert equipment.past_due(shared_catalogue, date(2026, 3, 1)) == []


def test_the_trail_is_not_changed_on_postgresql(shared_catalogue: Home) -> None:
    with database.changing(shared_catalogue) as connection:
        trail.add(connection, "Li", "check", "A-1")
    for change in (sql.update(tables.trail).values(person="another"), sql.delete(tables.trail)):
        with (
            pytest.raises(sql.exc.DatabaseError, match="append-only"),
            database.changing(shared_catalogue) as connection,
        ):
            connection.execute(change)
    assert list(trail.faults(shared_catalogue)) == []


def test_results_saved_at_once_on_postgresql_form_one_line(
    shared_catalogue: Home,
    small: Build,
    calibrated: Callable[..., Calibration],
    at_once: AtOnce,
) -> None:
    run = runs.add(small(), shared_catalogue)[0]
    script = """
import os
from schemas.calibration import Calibration
document = Calibration.model_validate_json(arguments[0])
print(results.save(document.model_copy(update={"code_version": str(os.getpid())}), home))
"""
    at_once(script, shared_catalogue, calibrated(run).model_dump_json(), processes=3)
    kept = results.of_run(run, shared_catalogue)
    assert [result.supersedes for result in kept] == [None, kept[0].id, kept[1].id]


def test_catalogue_of_a_newer_program_is_refused_on_postgresql(shared_catalogue: Home) -> None:
    with database.changing(shared_catalogue) as connection:
        connection.execute(sql.text("UPDATE alembic_version SET version_num = '9999'"))
    engine_of(url_of(shared_catalogue), database.BUSY_S).dispose()  # as in another process
    with pytest.raises(Unusable, match="update mimucal"):
        run_index.all_runs(shared_catalogue)


def test_a_row_says_whether_it_is_new_on_postgresql(shared_catalogue: Home) -> None:
    values = {"nonce": "n", "taken_at": datetime.now(UTC)}
    with database.changing(shared_catalogue) as connection:
        new = [database.add_new(connection, tables.signatures, **values) for _ in range(2)]
    assert new == [True, False]


def test_history_is_made_again_and_asked_for_as_in_sqlite(
    shared_catalogue: Home, small: Build, calibrated: Callable[..., Calibration]
) -> None:
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


def test_of_processes_that_claim_orders_on_postgresql_each_order_has_one(
    shared_catalogue: Home, at_once: AtOnce
) -> None:
    numbers = [str(number) for number in range(20)]
    orders.add([order(number) for number in numbers], shared_catalogue)
    assert orders.add([order("0")], shared_catalogue)[0][1] is False
    claimed = [eval(text) for text in at_once(CLAIM, shared_catalogue, processes=4)]
    assert sorted(chain(*claimed), key=int) == numbers
    orders.put_back("T1", shared_catalogue)
    assert [each.is_interrupted for each in orders.waiting(shared_catalogue)] == [True] * 20
