"""The command line in this process, on a home of its own; and homes for commands on their own."""

import fcntl
import json
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import typer.main

from flows import cli, execute
from flows.on_prefect.server import OWN_SERVER
from schemas.orders import CalibrateOrder
from storage.catalogue import runs
from storage.home import Home
from tasks.validation import record

MAKE_DATABASE = """
import asyncio
from prefect.server.database import provide_database_interface
asyncio.run(provide_database_interface().create_db())
"""

SERVE = """
import socket, sys
from flows.on_prefect.server import serve
serve(socket.socket(fileno=int(sys.argv[1])))
"""

built = cache(typer.main.get_command)  # from all the signatures, at every call of the app


@pytest.fixture
def home(tmp_path, monkeypatch, validated) -> Path:
    """An empty home folder, named by MIMUCAL_HOME; this code's estimation counts as validated."""
    monkeypatch.setattr(record, "shipped", lambda: validated)
    folder = tmp_path / "home"
    monkeypatch.setenv("MIMUCAL_HOME", str(folder))
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    monkeypatch.delenv("PREFECT_API_URL", raising=False)
    return folder


@pytest.fixture(scope="session")
def prefect_database(pytestconfig) -> Path:
    """The database of a Prefect server before its first flow, kept in pytest's cache.

    Prefect makes it in seven seconds of a processor; each of its versions has its own.
    """
    folder = pytestconfig.cache.mkdir(f"prefect-{version('prefect')}")
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "made").exists():
            subprocess.run(
                [sys.executable, "-c", MAKE_DATABASE],
                check=True, capture_output=True, env=os.environ | {"PREFECT_HOME": str(folder)},
            )  # fmt: skip
            (folder / "made").touch()
    return folder / "prefect.db"


@pytest.fixture(scope="module")
def prefect_server(prefect_database, tmp_path_factory) -> Iterator[str]:
    """URL of a Prefect server that commands are told of, so that they start none of their own.

    It ends with the module, for it computes though nobody asks.
    """
    folder = tmp_path_factory.mktemp("prefect_server")
    shutil.copy(prefect_database, folder)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        url = f"http://127.0.0.1:{listener.getsockname()[1]}/api"
        server = subprocess.Popen(
            [sys.executable, "-c", SERVE, str(listener.fileno())],
            pass_fds=[listener.fileno()], stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env=os.environ | OWN_SERVER | {"PREFECT_HOME": str(folder)},
        )  # fmt: skip
    yield url
    server.terminate()
    server.wait(60)


@pytest.fixture
def mimucal(home, monkeypatch, capsys) -> Callable[..., Any]:
    """Runs `mimucal ARGS…`; gives code, out, err and the JSON document, if there is one."""

    monkeypatch.setattr(typer.main, "get_command", built)

    def run(*arguments: object) -> SimpleNamespace:
        monkeypatch.setattr(sys, "argv", ["mimucal", *map(str, arguments)])
        code = 0
        try:
            cli.main()
        except SystemExit as leaving:
            code = leaving.code or 0
        printed = capsys.readouterr()
        document = json.loads(printed.out) if "--json" in arguments and printed.out else None
        return SimpleNamespace(code=code, out=printed.out, err=printed.err, json=document)

    return run


@pytest.fixture(scope="session")
def plant_clean(shared, tmp_path_factory) -> Path:
    """A simulated unit without effects, every fifth row of it: commands do the same sooner."""
    return every_nth_row(shared / "plant/plant_clean", tmp_path_factory, 5)


@pytest.fixture(scope="session")
def plant_on_earth(shared, tmp_path_factory) -> Path:
    """The same of a run that is valid: its rests show Earth's rotation."""
    return every_nth_row(shared / "plant/plant_earth_rotation", tmp_path_factory, 5)


@pytest.fixture(scope="session")
def ahrs_clean(shared, tmp_path_factory) -> Path:
    """The same of an AHRS, with what is true of it."""
    source = shared / "plant/ahrs_clean"
    folder = every_nth_row(source, tmp_path_factory, 5)
    shutil.copy(source / "truth.json", folder)
    return folder


@pytest.fixture(scope="session")
def calibrated_once(plant_on_earth, tmp_path_factory) -> Path:
    """A home with one run, `plant_on_earth`, that is calibrated."""
    folder = tmp_path_factory.mktemp("calibrated") / "home"
    with pytest.MonkeyPatch.context() as patch:
        for name in ("MIMUCAL_DATABASE", "MIMUCAL_STORE"):
            patch.delenv(name, raising=False)
        patch.setenv("MIMUCAL_HOME", str(folder))
        execute.calibrate(CalibrateOrder(run=str(plant_on_earth)))
    return folder


@pytest.fixture
def run_on_earth(calibrated_once, home) -> str:
    """The id of that run, which this home holds as well."""
    shutil.copytree(calibrated_once, home)
    (run,) = runs.all_runs(Home(home))
    return run.id


def every_nth_row(source: Path, folders: pytest.TempPathFactory, n: int) -> Path:
    target = folders.mktemp("every_nth_row") / source.name
    target.mkdir()
    for name in ("manifest.json", "environment.parquet"):
        if (source / name).exists():
            shutil.copy(source / name, target)
    for name in ("imu.parquet", "table.parquet"):
        rows = pq.read_table(source / name)
        pq.write_table(rows.take(pa.array(range(0, len(rows), n))), target / name)
    return target


@pytest.fixture
def copied(tmp_path, shared) -> Callable[[str], Path]:
    """A copy of a shared recording that a test may spoil."""

    def copy(name: str) -> Path:
        source, target = shared / name, tmp_path / Path(name).name
        target.mkdir()
        for path in source.iterdir():
            if path.suffix in (".json", ".parquet", ".csv"):
                (target / path.name).write_bytes(path.read_bytes())
        return target

    return copy
