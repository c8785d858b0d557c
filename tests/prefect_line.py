"""A Prefect server as a line has it, behind a password, with workers: each a process of its own."""

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

from tasks.stages.prefect_api import NotAnswered, get, post

PASSWORD = "line:a-long-password"
START_UP_S = 300.0
SERVER = {
    "PREFECT_SERVER_API_AUTH_STRING": PASSWORD,
    "PREFECT_SERVER_CONCURRENCY_LEASE_STORAGE":
        "prefect.server.concurrency.lease_storage.filesystem",
    "PREFECT_SERVER_ANALYTICS_ENABLED": "false",
    "PREFECT_API_BLOCKS_REGISTER_ON_START": "false",
    "PREFECT_SERVER_SERVICES_SCHEDULER_LOOP_SECONDS": "2",
    "PREFECT_SERVER_SERVICES_LATE_RUNS_LOOP_SECONDS": "2",
    "PREFECT_SERVER_LOGGING_LEVEL": "WARNING",
    "DO_NOT_TRACK": "1",
}  # fmt: skip


class PrefectLine:
    """A server on a port of its own, in a folder of its own; it can be killed and started anew."""

    def __init__(self, folder: Path, database: Path) -> None:
        self.folder, self.home = folder, folder / "home"
        (folder / "prefect").mkdir(parents=True)
        shutil.copy(database, folder / "prefect")
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.url = f"http://127.0.0.1:{self.port}/api"
        self.server: subprocess.Popen[bytes] | None = None
        self.workers: list[subprocess.Popen[bytes]] = []

    def environment(self, **more: str) -> dict[str, str]:
        """That of every process of the line but the server."""
        own = {k: v for k, v in os.environ.items() if not k.startswith(("PREFECT_", "MIMUCAL_"))}
        return own | {
            "MIMUCAL_HOME": str(self.home), "PREFECT_API_URL": self.url, "DO_NOT_TRACK": "1",
            "PREFECT_API_AUTH_STRING": PASSWORD, "PREFECT_HOME": str(self.folder / "client"),
            "PREFECT_WORKER_QUERY_SECONDS": "1", "OPENBLAS_NUM_THREADS": "1",
        } | more  # fmt: skip

    def start(self) -> None:
        """Start the server, and wait until it answers."""
        own = {k: v for k, v in os.environ.items() if not k.startswith(("PREFECT_", "MIMUCAL_"))}
        log = (self.folder / "server.log").open("ab")
        self.server = subprocess.Popen(
            [sys.executable, "-m", "prefect", "server", "start", "--host", "127.0.0.1",
             "--port", str(self.port)],
            stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True,
            env=own | SERVER | {"PREFECT_HOME": str(self.folder / "prefect")},
        )  # fmt: skip
        log.close()
        wait_for(lambda: get("/health"), START_UP_S)

    def kill_server(self) -> None:
        """As a power cut would."""
        assert self.server is not None
        with suppress(ProcessLookupError):
            os.killpg(self.server.pid, 9)
        self.server.wait(60)

    def work(self, pool: str, **more: str) -> "subprocess.Popen[bytes]":
        """Start a worker of a pool."""
        log = (self.folder / f"worker-{len(self.workers)}.log").open("ab")
        worker = subprocess.Popen(
            [sys.executable, "-m", "prefect", "worker", "start", "--pool", pool, "--type",
             "process", "--name", f"{pool}-{len(self.workers)}"],
            stdin=subprocess.DEVNULL, stdout=log, stderr=log, env=self.environment(**more),
            start_new_session=True,
        )  # fmt: skip
        log.close()
        self.workers.append(worker)
        return worker

    def mimucal(self, *arguments: object) -> str:
        """What a command of the line prints."""
        done = subprocess.run(
            [sys.executable, "-m", "flows.cli", *map(str, arguments)],
            capture_output=True, text=True, timeout=300, env=self.environment(),
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def end(self) -> None:
        for worker in self.workers:
            worker.terminate()
        for worker in self.workers:
            with suppress(subprocess.TimeoutExpired):
                worker.wait(30)
            with suppress(ProcessLookupError):
                os.killpg(worker.pid, 9)
            worker.wait(30)
        if self.server is not None and self.server.poll() is None:
            self.kill_server()


@contextmanager
def prefect_line(folder: Path, database: Path) -> Iterator[PrefectLine]:
    """A line whose server answers; this process may ask it, too. All of it ends with the block."""
    line = PrefectLine(folder, database)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PREFECT_API_URL", line.url)
        patch.setenv("PREFECT_API_AUTH_STRING", PASSWORD)
        try:
            line.start()
            yield line
        finally:
            line.end()


def wait_for(look: Callable[[], Any], for_s: float) -> Any:
    """What a look gives, once it gives something; a server that does not answer gives nothing."""
    end_s = time.monotonic() + for_s
    while time.monotonic() < end_s:
        with suppress(NotAnswered):
            if found := look():
                return found
        time.sleep(0.3)
    raise AssertionError(f"nothing came of it within {for_s:g} s")


def flow_runs(deployment: str, *states: str) -> list[dict[str, Any]]:
    """The flow runs of a deployment (`flow/name`) in some states, else in all, as due."""
    flow, name = deployment.split("/")
    asked: dict[str, Any] = {
        "flows": {"name": {"any_": [flow]}},
        "deployments": {"name": {"any_": [name]}},
        "sort": "EXPECTED_START_TIME_ASC",
    }
    if states:
        asked["flow_runs"] = {"state": {"type": {"any_": list(states)}}}
    return list(post("/flow_runs/filter", asked))
