"""The home: where it is, and files that are written once."""

import os
import re
import shutil
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
import sqlalchemy as sql

from schemas.base import Unusable
from storage import verify, whole_files
from storage.catalogue import certificates, database, runs, tables
from storage.catalogue.runs import Run
from storage.home import Home, home
from storage.whole_files import writing_to
from tests.keep import take_number
from tests.storage.small import small

# A home that cannot be written is read all the same; one that was damaged says so.

READ = """
import os, sys
from pathlib import Path
import sqlalchemy.dialects.sqlite
from schemas.base import Unusable
from storage.catalogue import certificates, runs
from storage.catalogue import runs as run_index
from tests.keep import take_number
from storage.formats.content import read_columns
from storage.home import Home
from storage.verify import verify
home = Home(Path(sys.argv[1]))
read_columns(next(home.columns.iterdir()))  # the other user may not read what it imports late
if os.geteuid() == 0:
    os.setgroups([])
    os.setgid(65534)
    os.setuid(65534)
(run,) = run_index.all_runs(home)
faults = [fault.why for fault in verify(home)[1]]
print(run_index.find(run.id, home).id, len(runs.load(run, home).imu.t), faults)
try:
    take_number(home)
except Unusable as error:
    print(error)
"""


@pytest.fixture
def read_only(fresh) -> Iterator[tuple[Home, Run]]:
    """A copy of a home with one run, readable for everybody and writable for nobody."""
    run = runs.add(small(), fresh)[0]
    with tempfile.TemporaryDirectory(prefix="mimucal-ro-") as name:
        copy = Path(name) / "home, 100% read-only?"
        shutil.copytree(fresh.path, copy)
        folders = [Path(name), copy, *(path for path in copy.rglob("*") if path.is_dir())]
        for path in copy.rglob("*"):
            path.chmod(0o444)
        for folder in folders:
            folder.chmod(0o555)
        yield Home(copy), run
        for folder in folders:
            folder.chmod(0o755)


def test_home_that_cannot_be_written_is_read(read_only):
    home, run = read_only
    before = sorted(home.path.iterdir())
    command = [sys.executable, "-W", "error", "-c", READ, str(home.path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert done.stderr == ""
    listed, refused = done.stdout.splitlines()
    assert listed == f"{run.id} 300 []"
    assert "cannot be used" in refused
    assert sorted(home.path.iterdir()) == before


def test_an_older_catalogue_that_cannot_be_written_is_refused(fresh, monkeypatch):
    runs.add(small(), fresh)
    with database.changing(fresh) as connection:
        connection.execute(sql.text("UPDATE alembic_version SET version_num = '0013'"))
    monkeypatch.setattr(os, "access", lambda *_: False)
    catalogue = re.escape(str(fresh.path / "catalog.sqlite"))
    with pytest.raises(Unusable, match=f"^{catalogue} has revision 0013.*copy the home"):
        runs.all_runs(fresh)


def test_home_that_is_a_file_is_refused_for_reading(fresh):
    fresh.path.write_text("")
    for read in (runs.all_runs, certificates.register, verify.verify):
        with pytest.raises(Unusable, match="MIMUCAL_HOME"):
            read(fresh)


def test_empty_catalogue_beside_raw_recordings_is_not_taken_as_empty(fresh):
    run = runs.add(small(), fresh)[0]
    for file in fresh.path.glob("catalog.sqlite-*"):
        file.unlink()
    os.truncate(fresh.path / "catalog.sqlite", 0)
    for read in (runs.all_runs, lambda home: runs.find(run.id, home)):
        with pytest.raises(Unusable, match="backup"):
            read(fresh)
    assert (fresh.path / "catalog.sqlite").stat().st_size == 0


def test_empty_catalogue_of_an_empty_home_is_made(fresh):
    fresh.path.mkdir()
    (fresh.path / "catalog.sqlite").touch()
    assert runs.all_runs(fresh) == []
    with database.changing(fresh) as connection:
        assert connection.scalar(sql.select(sql.func.count()).select_from(tables.runs)) == 0


def test_home_is_where_the_environment_says(monkeypatch):
    monkeypatch.setenv("MIMUCAL_HOME", "somewhere")
    assert home().path == Path.cwd() / "somewhere"
    monkeypatch.delenv("MIMUCAL_HOME")
    assert home().path == Path.cwd() / "mimucal-data"


def test_catalogue_is_a_file_in_the_home_unless_the_environment_names_a_database(
    fresh, monkeypatch
):
    assert fresh.database_url == f"sqlite:///{fresh.path}/catalog.sqlite"
    monkeypatch.setenv("MIMUCAL_DATABASE", "postgresql://lab@host/mimucal")
    assert fresh.database_url == "postgresql://lab@host/mimucal"


def test_looking_into_a_fresh_home_finds_nothing_and_makes_nothing(fresh):
    assert runs.all_runs(fresh) == []
    assert certificates.register(fresh) == []
    assert verify.verify(fresh) == (0, [])
    with pytest.raises(Unusable, match="mimucal runs"):
        runs.find("r1", fresh)
    assert not fresh.path.exists()


def test_written_file_is_whole_and_read_only(tmp_path):
    path = tmp_path / "new" / "file"
    with writing_to(path) as draft:
        draft.write_bytes(b"content")
    assert path.read_bytes() == b"content"
    assert stat.S_IMODE(path.stat().st_mode) == 0o400
    assert list(path.parent.iterdir()) == [path]


def test_nothing_half_stays_when_writing_fails(tmp_path):
    def write() -> None:
        with writing_to(tmp_path / "file") as draft:
            draft.write_bytes(b"half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        write()
    assert list(tmp_path.iterdir()) == []


def test_home_that_cannot_be_written_is_one_sentence(fresh):
    fresh.path.write_text("a file stands where the folder should be")
    refused = pytest.raises(Unusable, match=r"MIMUCAL_HOME")
    with refused as caught, writing_to(fresh.raw / "file"):
        pass
    assert os.linesep not in str(caught.value)
    with pytest.raises(Unusable, match=r"MIMUCAL_HOME"):
        take_number(fresh)


@pytest.mark.parametrize("name", ["with space", "100% a?b#c@d", "实验室"])
def test_home_may_have_any_name(fresh, name):
    odd = Home(fresh.path / name)
    take_number(odd)
    assert (odd.path / "catalog.sqlite").is_file()
    assert list(fresh.path.iterdir()) == [odd.path]


# Secrets in files: made once, and read only where nobody else can read them.


def test_a_secret_is_made_once_for_its_owner_alone(tmp_path):
    tmp_path.chmod(0o755)  # a home that everybody may read does not share it
    path = tmp_path / "orders.key"
    made = whole_files.made(path)
    assert whole_files.made(path) == whole_files.read(path) == made
    assert path.stat().st_mode & 0o777 == 0o600
    assert [each.name for each in tmp_path.iterdir()] == ["orders.key"]


@pytest.mark.parametrize("rights", [0o640, 0o604, 0o660])
def test_a_secret_that_others_may_read_is_none(tmp_path, rights):
    path = tmp_path / "orders.key"
    whole_files.made(path)
    path.chmod(rights)
    with pytest.raises(Unusable, match="chmod 600"):
        whole_files.made(path)


def test_a_link_in_the_place_of_a_secret_is_refused(tmp_path):
    whole_files.made(tmp_path / "known.key")
    (tmp_path / "orders.key").symlink_to(tmp_path / "known.key")
    with pytest.raises(Unusable, match="a file of its own"):
        whole_files.made(tmp_path / "orders.key")


def test_what_is_too_short_to_be_a_secret_is_refused(tmp_path):
    path = tmp_path / "proxy.secret"
    path.write_text("secret\n")
    path.chmod(0o600)
    with pytest.raises(Unusable, match="6 characters"):
        whole_files.read(path)


def test_a_secret_that_is_missing_is_not_made_by_reading(tmp_path):
    with pytest.raises(Unusable, match="cannot be read"):
        whole_files.read(tmp_path / "orders.key")
    assert not list(tmp_path.iterdir())
