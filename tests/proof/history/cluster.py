"""A dask scheduler with two workers, PostgreSQL, an S3 server and a Prefect server.

What ends of dask is started again within a second, as systemd does with `Restart=always`.
"""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import httpx
import sqlalchemy as sql

from storage.catalogue import database, tables
from storage.home import Home
from tests import postgres
from tests.proof.history.watch import environment

WORKERS = 2
COPIED = (tables.units, tables.runs, tables.equipment, tables.sources)  # of an import
UNPROFILED = {"DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "false"}  # nobody looks at it
KEYS = {"AWS_ACCESS_KEY_ID": "of-a-proof", "AWS_SECRET_ACCESS_KEY": "of-a-proof"}


class Cluster:
    """The processes of a cluster. variables: the environment of its workers and its commands."""

    def __init__(
        self, database_server: postgres.Server, url: str, variables: dict[str, str]
    ) -> None:
        self.database = database_server
        self.variables = variables
        self.url = url
        self.address = f"tcp://127.0.0.1:{_free_port()}"
        self._scheduler = self._start("dask_scheduler", "--host", self.address)
        self._workers = [self._worker() for _ in range(WORKERS)]

    def keep_up(self) -> None:
        """Starts again what ended."""
        if self._scheduler.poll() is not None:
            self._scheduler = self._start("dask_scheduler", "--host", self.address)
        self._workers = [each if each.poll() is None else self._worker() for each in self._workers]

    def kill_worker(self) -> None:
        self._workers[0].send_signal(signal.SIGKILL)
        self._workers[0].wait(60)

    def kill_scheduler(self) -> None:
        self._scheduler.send_signal(signal.SIGKILL)
        self._scheduler.wait(60)

    def end(self) -> None:
        for process in (*self._workers, self._scheduler):
            process.kill()
            process.wait(60)

    def _worker(self) -> "subprocess.Popen[bytes]":
        return self._start(
            "dask_worker", self.address, "--nthreads", "1", "--no-nanny",
            "--death-timeout", "60", "--preload", "tasks.stages.make_again",
        )  # fmt: skip

    def _start(self, program: str, *arguments: str) -> "subprocess.Popen[bytes]":
        return subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.{program}", *arguments, "--no-dashboard"],
            env=self.variables | UNPROFILED | {"PYTHONPATH": os.getcwd()},
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip


@contextmanager
def running(home: Home, objects: Path, every: int = 0, pause_s: float = 0.0) -> Iterator[Cluster]:
    """A cluster on an empty catalogue, whose bucket is the store in a folder.

    home: of the commands and the workers, with nothing in it. every, pause_s: as in `bucket`.
    """
    with (
        postgres.serving() as server,
        _bucket(objects, every, pause_s) as store,
        _prefect(home.path) as prefect,
    ):
        url = postgres.empty_database(server.connection)
        variables = environment(
            MIMUCAL_HOME=str(home.path), MIMUCAL_DATABASE=url, MIMUCAL_STORE=store,
            PREFECT_API_URL=prefect, **KEYS,
        )  # fmt: skip
        cluster = Cluster(server, url, variables)
        try:
            yield cluster
        finally:
            cluster.end()


@contextmanager
def _bucket(folder: Path, every: int, pause_s: float) -> Iterator[str]:
    command = (sys.executable, "-m", "tests.proof.history.bucket", folder, every, pause_s)
    with subprocess.Popen(
        list(map(str, command)), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        env=environment(),
    ) as process:  # fmt: skip
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            yield process.stdout.readline().strip()
        finally:
            process.stdin.close()


@contextmanager
def _prefect(folder: Path) -> Iterator[str]:
    """A Prefect server with its database in the folder, as a laboratory keeps one running."""
    folder.mkdir(parents=True, exist_ok=True)
    port = _free_port()
    url = f"http://127.0.0.1:{port}/api"
    with subprocess.Popen(
        [sys.executable, "-m", "prefect", "server", "start", "--port", str(port)],
        env=environment(PREFECT_HOME=str(folder / "prefect"), DO_NOT_TRACK="1"),
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    ) as process:  # fmt: skip
        try:
            while True:
                assert process.poll() is None, "Prefect's server stopped at its start"
                with suppress(httpx.TransportError):
                    httpx.get(f"{url}/health", trust_env=False).raise_for_status()
                    break
                time.sleep(0.1)
            yield url
        finally:
            process.terminate()


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as free:
        return int(free.getsockname()[1])


def copy_runs(source: Home, url: str, count: int) -> None:
    """Copies the rows of the first runs of a catalogue, as their import made them, into another."""
    rows = {table: database.rows(source, sql.select(table)) for table in COPIED}
    runs = sorted(rows[tables.runs], key=lambda row: (row.imported_at, row.id))[:count]
    ids = {row.id for row in runs}
    with catalogue(url), database.changing(source) as connection:
        for table, found in rows.items():
            mine = [
                row._asdict()
                for row in found
                if table is tables.units or row._mapping.get("run", row._mapping.get("id")) in ids
            ]
            database.add_all_new(connection, table, mine)


@contextmanager
def catalogue(url: str) -> Iterator[None]:
    """Within it, homes in this process have their catalogue in that database."""
    os.environ["MIMUCAL_DATABASE"] = url
    try:
        yield
    finally:
        del os.environ["MIMUCAL_DATABASE"]


def kept_results(home: Home) -> dict[str, list[tuple[str, str]]]:
    """Id and document of every result, the oldest first, by run."""
    asked = sql.select(tables.results).order_by(tables.results.c.made_at)
    found: dict[str, list[tuple[str, str]]] = {}
    for row in database.rows(home, asked):
        found.setdefault(row.run, []).append((row.id, row.document))
    return found
