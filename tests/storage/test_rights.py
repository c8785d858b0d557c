"""Who may read what a home holds."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from storage.catalogue import database
from storage.home import Home
from storage.whole_files import make_folder, writing_in_home, writing_to
from tests.drafts import draft


@pytest.fixture(autouse=True)
def _usual_umask() -> Iterator[None]:
    before = os.umask(0o022)
    yield
    os.umask(before)


def rights(path: Path) -> int:
    return path.stat().st_mode & 0o777


def test_a_new_home_is_its_owners_alone(tmp_path, monkeypatch):
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    tmp_path.chmod(0o755)
    home = Home(tmp_path / "home")
    with database.changing(home):
        made = {each.name: rights(each) for each in home.path.glob("catalog.sqlite*")}
    draft(home)
    assert {"catalog.sqlite", "catalog.sqlite-wal"} <= set(made)
    assert set(made.values()) == {0o600}
    assert rights(home.path) == 0o700
    open_to_others = [
        str(each) for each in home.path.rglob("*") if rights(each) & 0o077 and each.is_file()
    ]
    assert open_to_others == []


def test_a_home_that_a_group_shares_on_purpose_is_shared_with_the_group_alone(tmp_path):
    tmp_path.chmod(0o2770)
    with writing_to(tmp_path / "raw" / "a.mcap") as recording:
        recording.write_bytes(b"content")
    with writing_in_home(tmp_path / "locks" / "T1"):
        (tmp_path / "locks" / "T1").touch()
    assert rights(tmp_path / "raw") == 0o770
    assert (tmp_path / "raw").stat().st_mode & 0o2000
    assert rights(tmp_path / "raw/a.mcap") == 0o440
    assert rights(tmp_path / "locks/T1") == 0o660


def test_a_home_of_before_keeps_the_rights_that_it_has(tmp_path):
    tmp_path.chmod(0o755)
    (tmp_path / "laboratory.toml").touch(0o644)
    with writing_in_home(tmp_path / "laboratory.toml"):
        pass
    with writing_to(tmp_path / "a.pdf") as paper:
        paper.write_bytes(b"content")
    make_folder(tmp_path)
    assert (rights(tmp_path), rights(tmp_path / "laboratory.toml")) == (0o755, 0o644)
    assert rights(tmp_path / "a.pdf") == 0o444


def test_a_catalogue_is_not_for_everybody_even_in_an_open_home(tmp_path):
    tmp_path.chmod(0o755)
    with database.changing(Home(tmp_path)):
        pass
    assert rights(tmp_path / "catalog.sqlite") & 0o007 == 0
