"""A fresh home, small recordings and results, and processes that do a thing at the same time."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

from storage.catalogue import database
from storage.home import Home
from tests import postgres

AT_ONCE = """
import json
import os
import sys
from contextlib import redirect_stdout
from datetime import date
from io import StringIO
from multiprocessing import get_context
from pathlib import Path

from storage.catalogue import certificates, results, runs
from storage.formats import recordings
from storage.home import Home

forked = get_context("fork")  # one import for all of them

def run(_):
    everybody.wait()
    with redirect_stdout(StringIO()) as printed:
        exec(script, globals())
    return printed.getvalue()

for line in sys.stdin:
    folder, script, processes, arguments, database = json.loads(line)
    home, everybody = Home(Path(folder)), forked.Barrier(processes)
    os.environ.pop("MIMUCAL_DATABASE", None)
    os.environ.update(database)
    with forked.Pool(processes) as pool:
        answers = pool.map(run, range(processes), chunksize=1)
    print(json.dumps(answers), flush=True)
"""


@pytest.fixture(scope="session")
def server() -> Iterator[str]:
    """The connection of a PostgreSQL."""
    with postgres.running() as connection:
        yield connection


@pytest.fixture(params=["sqlite", "postgresql"])
def either(request, fresh, monkeypatch) -> Home:
    """A fresh home whose catalogue is a file of its own, or an empty database on a server."""
    if request.param == "postgresql":
        server = request.getfixturevalue("server")
        monkeypatch.setenv("MIMUCAL_DATABASE", postgres.empty_database(server))
    return fresh


@pytest.fixture(scope="session")
def forking() -> Iterator[subprocess.Popen[str]]:
    """A process that carries out AT_ONCE, with all of its imports."""
    with subprocess.Popen(
        [sys.executable, "-W", "error", "-c", AT_ONCE],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        yield process


@pytest.fixture
def at_once(forking) -> Callable[..., list[str]]:
    """Runs a script in several processes that all start it at the same moment.

    The script knows store, Home, Path, date, home and arguments; gives what each printed. The
    catalogue is there already, unless the processes are to make it.
    """

    def run(
        script: str, home: Home, *arguments: str, processes: int = 2, has_catalogue: bool = True
    ) -> list[str]:
        if has_catalogue:
            with database.changing(home):
                pass
        named = {k: v for k, v in os.environ.items() if k == "MIMUCAL_DATABASE"}
        assert forking.stdin is not None
        assert forking.stdout is not None
        order = [str(home.path), script, processes, arguments, named]
        print(json.dumps(order), file=forking.stdin, flush=True)
        printed = forking.stdout.readline()
        assert printed, "a process failed: see its messages"
        return list(json.loads(printed))

    return run
