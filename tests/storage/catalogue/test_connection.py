"""Connections to the catalogue: how often its file is opened, and that it is closed again."""

from concurrent.futures import ThreadPoolExecutor

import psutil
import pytest
import sqlalchemy as sql

from schemas.base import Unusable
from storage.catalogue import database, tables
from storage.catalogue.database import BUSY_S, engine_of, opened_once, url_of
from storage.home import Home

FILE = "catalog.sqlite"


def read(home: Home) -> None:
    assert database.rows(home, sql.select(tables.units)) == []


@pytest.fixture
def home(tmp_path) -> Home:
    made = Home(tmp_path)
    with database.changing(made):
        pass
    return made


def test_within_it_a_file_is_opened_once_and_closed_at_the_end(home):
    opened: list[object] = []
    closed: list[object] = []
    with opened_once(home, BUSY_S):
        kept = engine_of(url_of(home), BUSY_S)
        sql.event.listen(kept, "connect", lambda *_: opened.append(1))
        sql.event.listen(kept, "close", lambda *_: closed.append(1))
        for _ in range(3):
            read(home)
        assert not closed
    assert len(opened) == len(closed) == 1
    assert not home.path.joinpath(f"{FILE}-wal").exists()


def test_many_threads_each_close_their_own(home):
    def work(_: int) -> None:
        with opened_once(home, BUSY_S):
            for _ in range(5):
                read(home)

    with ThreadPoolExecutor(20) as threads:
        list(threads.map(work, range(60)))
    # Its log may stay where the last two close at once: each takes the other for a reader
    assert not [each for each in psutil.Process().open_files() if str(home.path) in each.path]


def test_a_database_that_cannot_be_named_leaves_nothing_behind(home, monkeypatch):
    before = engine_of(url_of(home), BUSY_S)
    with monkeypatch.context() as patched:
        patched.setenv("MIMUCAL_DATABASE", "nonsense")
        with pytest.raises(Unusable), opened_once(home, BUSY_S):
            pytest.fail("nothing can be read there")
    assert engine_of(url_of(home), BUSY_S) is before
