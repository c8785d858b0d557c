"""Answers that are kept while nothing is written."""

import sqlalchemy as sql

from storage.catalogue import database
from storage.catalogue.database import cached_until_commit, engine_of, url_of, version
from storage.catalogue.users import add, users
from storage.home import Home


def test_an_answer_is_asked_for_again_after_a_write_and_only_then(tmp_path) -> None:
    asked = []

    @cached_until_commit(4)
    def names(prefix: str, home: Home) -> list[str]:
        asked.append(prefix)
        return [name for name in users(home) if name.startswith(prefix)]

    home = Home(tmp_path / "home")
    assert names("L", home) == []
    add("Li", "viewer", "hash", home, "Chen")
    assert names("L", home) == ["Li"]
    assert names("L", home) == ["Li"]
    assert names("W", home) == []
    assert asked == ["L", "L", "W"]


def test_a_write_within_one_tick_of_the_file_system_is_another_version(
    tmp_path, monkeypatch
) -> None:
    monkeypatch.setattr(database, "_stamp", lambda file: "the same")
    home = Home(tmp_path / "home")
    with database.changing(home):
        pass
    file = engine_of(url_of(home), database.BUSY_S)
    with file.connect() as reader:  # keeps the log from being emptied
        reader.execute(sql.text("SELECT 1"))
        add("Li", "viewer", "hash", home, "Chen")
        before = version(home)
        assert version(home) == before
        add("Wu", "viewer", "hash", home, "Chen")
        assert version(home) != before
