"""The judge of the pages: it agrees with them, and sees a number that is not the catalogue's."""

import json
import shutil
import sqlite3
from pathlib import Path
from typing import Any

import pytest

from flows.pages.register import PAGES
from storage.home import Home
from tests.proof import line_pages
from tests.proof.line import Line
from tests.proof.line_pages import same


def wrong(shown_of: Home, database: Path) -> list[str]:
    """What the pages of a home say otherwise than a catalogue."""
    pages = {page.name: page for page in PAGES}

    def ask(name: str, asked: dict[str, str]) -> Any:
        page = pages[name]
        return json.loads(page.data(page.question(**asked), shown_of).model_dump_json())

    compared = line_pages.pairs(sqlite3.connect(database), ask)
    return [what for what, declared, own in compared if not same(declared, own)]


@pytest.fixture
def catalogue(line_store: tuple[Home, Line], tmp_path: Path) -> Path:
    """A copy that may be altered."""
    shutil.copy(line_store[0].path / "catalog.sqlite", tmp_path)
    return tmp_path / "catalog.sqlite"


def test_every_number_is_the_catalogues(line_store, catalogue: Path) -> None:
    assert wrong(line_store[0], catalogue) == []


@pytest.mark.parametrize(("change", "page"), [
    ("update elements set value = value + 1e-6 where item = 'gyro_bias'", "unit"),
    ("update outcomes set verdict = 'invalid'", "runs"),
    ("update certificates set due = '2027-01-01' where due is not null", "due"),
    ("insert or replace into explained select id, imported_at, '1', 'explained' from runs",
     "explained"),
])  # fmt: skip
def test_a_number_that_is_not_is_seen(line_store, catalogue: Path, change: str, page: str) -> None:
    database = sqlite3.connect(catalogue)
    database.execute(change)
    database.commit()
    assert any(what.startswith(page) for what in wrong(line_store[0], catalogue))
