"""A line under attack: a Prefect server with authentication, and what carries out its flows."""

import os
import secrets
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx

from storage.home import Home

FLOWS = ("check", "issue", "withdraw", "amend", "certify", "produce")
WAIT_S = 600.0  # a machine that is busy with other work
AT_ONCE = 2
SERVE = f"""
from prefect import serve
from flows.on_prefect import prefect_flows
serve(*(getattr(prefect_flows, n).to_deployment(n) for n in {FLOWS!r}), limit={AT_ONCE})
"""


@dataclass(frozen=True)
class Line:
    """api: of the server. auth: its name and password. log: what the server writes."""

    api: str
    auth: tuple[str, str]
    log: Path

    def ask(self, method: str, path: str, content: Any = None, **more: Any) -> httpx.Response:
        """Somebody who has the server's password, and asks again while the server is busy."""
        end_s = time.monotonic() + WAIT_S
        while True:
            answer = httpx.request(
                method, f"{self.api}{path}", json=content, auth=self.auth, timeout=60.0, **more
            )
            if answer.status_code != httpx.codes.SERVICE_UNAVAILABLE or time.monotonic() > end_s:
                return answer
            time.sleep(1.0)

    def order(self, flow: str, parameters: dict[str, Any]) -> str:
        """The id of a flow run that is ordered with these parameters."""
        deployment = self.ask("GET", f"/deployments/name/{flow}/{flow}").json()["id"]
        made = self.ask(
            "POST", f"/deployments/{deployment}/create_flow_run",
            {"parameters": {"order": parameters}, "state": {"type": "SCHEDULED"}},
        )  # fmt: skip
        made.raise_for_status()
        return str(made.json()["id"])

    def ended(self, runs: list[str]) -> dict[str, tuple[str, str]]:
        """How each of some flow runs ended: the type of its state, and its message."""
        asked = {"flow_runs": {"id": {"any_": runs}}, "limit": 200}
        end_s = time.monotonic() + WAIT_S
        while True:
            found = self.ask("POST", "/flow_runs/filter", asked).json()
            states = {each["id"]: each["state"] for each in found}
            final = {"COMPLETED", "FAILED", "CRASHED", "CANCELLED"}
            if all(s["type"] in final for s in states.values()) or time.monotonic() > end_s:
                return {run: (s["type"], s["message"] or "") for run, s in states.items()}
            time.sleep(2.0)


@contextmanager
def line_at(home: Home, folder: Path) -> Iterator[Line]:
    """A server and what carries out its flows, as `deploy/README.md` has them; both end with it."""
    password = secrets.token_hex(16)
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    keep = {k: v for k, v in os.environ.items() if not k.startswith(("PREFECT_", "MIMUCAL_"))}
    common = keep | {
        "PREFECT_HOME": str(folder), "PREFECT_API_URL": f"http://127.0.0.1:{port}/api",
        "PREFECT_API_AUTH_STRING": f"line:{password}", "DO_NOT_TRACK": "1",
        "PREFECT_SERVER_ANALYTICS_ENABLED": "false", "MIMUCAL_HOME": str(home.path),
    }  # fmt: skip
    server = common | {
        "PREFECT_SERVER_API_AUTH_STRING": f"line:{password}",
        "PREFECT_SERVER_LOGGING_LEVEL": "INFO",
    }
    command = str(Path(sys.executable).with_name("prefect"))
    made = Line(f"http://127.0.0.1:{port}/api", ("line", password), folder / "server.log")
    start = [command, "server", "start", "--host=127.0.0.1", f"--port={port}"]
    with _process(start, server, made.log):
        _wait_for(made, ["/admin/version"])
        with _process([sys.executable, "-c", SERVE], common, folder / "flows.log"):
            _wait_for(made, [f"/deployments/name/{name}/{name}" for name in FLOWS])
            yield made


def _wait_for(made: Line, paths: list[str]) -> None:
    end_s = time.monotonic() + WAIT_S
    while time.monotonic() < end_s:
        with suppress(httpx.TransportError):
            if all(made.ask("GET", path).is_success for path in paths):
                return
        time.sleep(1.0)
    raise TimeoutError("the line did not start")


@contextmanager
def _process(command: list[str], environment: dict[str, str], log: Path) -> Iterator[None]:
    with log.open("wb") as output, subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=output, stderr=output, env=environment
    ) as process:  # fmt: skip
        try:
            yield
        finally:
            process.terminate()
            try:
                process.wait(60)
            except subprocess.TimeoutExpired:
                process.kill()
