"""The home: where it is, and files that are written once."""

import os
import stat
from pathlib import Path

import pytest

from schemas.base import Unusable
from storage import verify
from storage.catalogue import certificates, run_index
from storage.home import Home, home
from storage.whole_files import writing_to
from tests.keep import take_number


def test_home_is_where_the_environment_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MIMUCAL_HOME", "somewhere")
    assert home().path == Path.cwd() / "somewhere"
    monkeypatch.delenv("MIMUCAL_HOME")
    assert home().path == Path.cwd() / "mimucal-data"


def test_catalogue_is_a_file_in_the_home_unless_the_environment_names_a_database(
    fresh: Home, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert fresh.database_url == f"sqlite:///{fresh.path}/catalog.sqlite"
    monkeypatch.setenv("MIMUCAL_DATABASE", "postgresql://lab@host/mimucal")
    assert fresh.database_url == "postgresql://lab@host/mimucal"


def test_looking_into_a_fresh_home_finds_nothing_and_makes_nothing(fresh: Home) -> None:
    assert run_index.all_runs(fresh) == []
    assert certificates.register(fresh) == []
    assert verify.verify(fresh) == (0, [])
    with pytest.raises(Unusable, match="mimucal runs"):
        run_index.find("r1", fresh)
    assert not fresh.path.exists()


def test_written_file_is_whole_and_read_only(tmp_path: Path) -> None:
    path = tmp_path / "new" / "file"
    with writing_to(path) as draft:
        draft.write_bytes(b"content")
    assert path.read_bytes() == b"content"
    assert stat.S_IMODE(path.stat().st_mode) == 0o400
    assert list(path.parent.iterdir()) == [path]


def test_nothing_half_stays_when_writing_fails(tmp_path: Path) -> None:
    def write() -> None:
        with writing_to(tmp_path / "file") as draft:
            draft.write_bytes(b"half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        write()
    assert list(tmp_path.iterdir()) == []


def test_home_that_cannot_be_written_is_one_sentence(fresh: Home) -> None:
    fresh.path.write_text("a file stands where the folder should be")
    refused = pytest.raises(Unusable, match=r"MIMUCAL_HOME")
    with refused as caught, writing_to(fresh.raw / "file"):
        pass
    assert os.linesep not in str(caught.value)
    with pytest.raises(Unusable, match=r"MIMUCAL_HOME"):
        take_number(fresh)


@pytest.mark.parametrize("name", ["with space", "100% a?b#c@d", "实验室"])
def test_home_may_have_any_name(fresh: Home, name: str) -> None:
    odd = Home(fresh.path / name)
    take_number(odd)
    assert (odd.path / "catalog.sqlite").is_file()
    assert list(fresh.path.iterdir()) == [odd.path]
