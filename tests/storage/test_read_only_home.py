"""A home that cannot be written is read all the same; one that was damaged says so."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
import sqlalchemy as sql

from schemas.base import Unusable
from storage import verify
from storage.catalogue import certificates, database, run_index, runs, tables
from storage.catalogue.run_index import Run
from storage.home import Home
from tests.storage.small import small

READ = """
import os, sys
from pathlib import Path
import sqlalchemy.dialects.sqlite
from schemas.base import Unusable
from storage.catalogue import certificates, runs
from storage.catalogue import run_index
from tests.keep import take_number
from storage.formats.columns import read_columns
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
def read_only(fresh: Home) -> Iterator[tuple[Home, Run]]:
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


def test_home_that_cannot_be_written_is_read(read_only: tuple[Home, Run]) -> None:
    home, run = read_only
    before = sorted(home.path.iterdir())
    command = [sys.executable, "-W", "error", "-c", READ, str(home.path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert done.stderr == ""
    listed, refused = done.stdout.splitlines()
    assert listed == f"{run.id} 300 []"
    assert "cannot be used" in refused
    assert sorted(home.path.iterdir()) == before


def test_an_older_catalogue_that_cannot_be_written_is_refused(
    fresh: Home, monkeypatch: pytest.MonkeyPatch
) -> None:
    runs.add(small(), fresh)
    with database.changing(fresh) as connection:
        connection.execute(sql.text("UPDATE alembic_version SET version_num = '0013'"))
    monkeypatch.setattr(os, "access", lambda *_: False)
    catalogue = re.escape(str(fresh.path / "catalog.sqlite"))
    with pytest.raises(Unusable, match=f"^{catalogue} has revision 0013.*copy the home"):
        run_index.all_runs(fresh)


def test_home_that_is_a_file_is_refused_for_reading(fresh: Home) -> None:
    fresh.path.write_text("")
    for read in (run_index.all_runs, certificates.register, verify.verify):
        with pytest.raises(Unusable, match="MIMUCAL_HOME"):
            read(fresh)


def test_empty_catalogue_beside_raw_recordings_is_not_taken_as_empty(fresh: Home) -> None:
    run = runs.add(small(), fresh)[0]
    for file in fresh.path.glob("catalog.sqlite-*"):
        file.unlink()
    os.truncate(fresh.path / "catalog.sqlite", 0)
    for read in (run_index.all_runs, lambda home: run_index.find(run.id, home)):
        with pytest.raises(Unusable, match="backup"):
            read(fresh)
    assert (fresh.path / "catalog.sqlite").stat().st_size == 0


def test_empty_catalogue_of_an_empty_home_is_made(fresh: Home) -> None:
    fresh.path.mkdir()
    (fresh.path / "catalog.sqlite").touch()
    assert run_index.all_runs(fresh) == []
    with database.changing(fresh) as connection:
        assert connection.scalar(sql.select(sql.func.count()).select_from(tables.runs)) == 0
