"""Neither tests nor proof touch the database, store or home that the environment names."""

import os
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest

TINY = """
import os
from storage.catalogue import database, tables
from storage.home import Home, home
from tests.surroundings import OF_THE_TESTS

def test_that_writes_where_it_is_told_to(tmp_path):
    with database.changing(Home(tmp_path / "own")) as connection:
        connection.execute(tables.series.insert().values(pattern="P", last=1, before=0))
    assert (tmp_path / "own" / "catalog.sqlite").exists()
    assert home().path.name == "mimucal-data"
    named = {name for name in os.environ if name.startswith(("MIMUCAL_", "PREFECT_"))}
    assert named <= OF_THE_TESTS
"""


def canary(folder: Path) -> dict[str, str]:
    """An environment that names a database, a home, a store and a server in production."""
    with sqlite3.connect(folder / "production.sqlite") as made:
        made.execute("CREATE TABLE kept (what TEXT)")
    made.close()
    return {name: value for name, value in os.environ.items() if not name.startswith("PYTEST")} | {
        "MIMUCAL_DATABASE": f"sqlite:///{folder / 'production.sqlite'}",
        "MIMUCAL_HOME": str(folder / "production"),
        "MIMUCAL_STORE": "s3://production/line?endpoint=127.0.0.1:9&scheme=http",
        "PREFECT_API_URL": "http://127.0.0.1:9/api",
    }


def test_a_test_leaves_the_database_in_production_alone(tmp_path):
    tiny = tmp_path / "test_tiny.py"
    tiny.write_text(TINY)
    environment = canary(tmp_path)
    before = (tmp_path / "production.sqlite").read_bytes()
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "tests.conftest",
               "-p", "no:cacheprovider", str(tiny)]  # fmt: skip
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (tmp_path / "production.sqlite").read_bytes() == before
    assert not (tmp_path / "production").exists()


@pytest.mark.rehearsal
@pytest.mark.parametrize("module", ["tests.proof", "tests.bench"])
def test_proof_and_measurements_leave_production_before_they_begin(module, tmp_path):
    begun = (
        "import os, runpy, sys, argparse, typer\n"
        "def begun(*_, **__):\n"
        "    print(*(n for n in os.environ if n.startswith(('MIMUCAL_', 'PREFECT_'))), 'begun')\n"
        "    raise SystemExit\n"
        "typer.Typer.__call__ = argparse.ArgumentParser.parse_args = begun\n"
        f"runpy.run_module({module!r}, run_name='__main__')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", begun],
        env=canary(tmp_path) | {"PYTHONPATH": str(Path.cwd())},
        capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    assert done.stdout == "begun\n", done.stderr
