"""A server of a command's own, where it cannot start and where it is busy."""

import asyncio
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from itertools import chain, repeat
from multiprocessing import active_children
from pathlib import Path

import httpx
import prefect.settings
import pytest
from prefect.client import base
from prefect.settings import PREFECT_CLIENT_MAX_RETRIES, temporary_settings

from flows.on_prefect import server
from schemas.base import Unusable


def test_a_server_that_ends_at_once_is_one_sentence_with_its_log(tmp_path, monkeypatch):
    for name in ("PREFECT_API_URL", "PREFECT_HOME"):  # what is set meanwhile goes with the test
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.setattr(server, "serve", lambda listener: sys.exit("no room"))
    with pytest.raises(Unusable, match=r"see .*server\.log.*PREFECT_API_URL"):
        server._start(tmp_path, meanwhile=lambda: None)
    assert "no room" in (tmp_path / server.LOG).read_text()


def test_only_its_command_ends_a_server(tmp_path, monkeypatch):
    def serve(listener: socket.socket) -> None:
        print("serves")
        time.sleep(600)

    monkeypatch.setattr(server, "serve", serve)
    path = tmp_path / server.LOG
    with path.open("ab") as log, socket.create_server(("127.0.0.1", 0)) as listener:
        server._fork(listener, log)
    (child,) = active_children()
    while "serves" not in path.read_text():
        time.sleep(0.01)
    for stop in server.STOPPING:  # as `pkill -f mimucal` would
        os.kill(child.pid or 0, stop)
    child.join(0.2)
    assert child.is_alive()
    server._end(child)
    assert child.exitcode == -signal.SIGTERM


SERVING = """
import os, socket, sys, time
from flows.on_prefect import server as prefect_server
def serve(listener):
    print("serves", os.getpid(), flush=True)
    time.sleep(600)
prefect_server.serve = serve
with open(sys.argv[1], "ab") as log, socket.create_server(("127.0.0.1", 0)) as listener:
    prefect_server._fork(listener, log)
time.sleep(600)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the kernel of Linux ends it")
def test_a_server_ends_with_a_command_that_is_killed(tmp_path):
    log = tmp_path / server.LOG
    with subprocess.Popen([sys.executable, "-c", SERVING, log]) as command:
        while not (log.exists() and log.read_text().endswith("\n")):
            assert command.poll() is None
            time.sleep(0.01)
        command.kill()
    child = Path("/proc", log.read_text().split()[1])
    while child.exists() and "\nState:\tZ" not in (child / "status").read_text():
        time.sleep(0.01)


def test_a_setting_of_prefect_that_it_refuses_is_named(monkeypatch):
    monkeypatch.setenv("PREFECT_CLIENT_MAX_RETRIES", "many")
    monkeypatch.setattr(prefect.settings, "get_current_settings", prefect.settings.Settings)
    with pytest.raises(Unusable, match=r"max_retries is 'many'.*PREFECT_"):
        server._import_prefect()


def test_a_folder_that_cannot_be_written_is_a_sentence(tmp_path):
    (tmp_path / server.LOG).mkdir()  # no file can be opened there, as on a read-only disk
    with pytest.raises(Unusable, match=r"cannot be written .*MIMUCAL_HOME"):
        server._start(tmp_path, meanwhile=lambda: None)


def answering(statuses: Iterator[int], clock: Iterator[float]):
    """A server whose answers have these statuses, and whose clock reads these times."""

    async def app(scope, receive, send) -> None:
        await send({"type": "http.response.start", "status": next(statuses), "headers": []})
        await send({"type": "http.response.body", "body": b"{}"})

    return server.asked_again_when_busy(app, lambda: next(clock))


def asked(app, monkeypatch: pytest.MonkeyPatch) -> int:
    """The status that Prefect's client, which retries nothing, has in the end."""

    async def at_once(seconds: float) -> None: ...

    async def ask() -> int:
        transport = httpx.ASGITransport(app=app)
        async with base.PrefectHttpxAsyncClient(
            transport=transport, base_url="http://server", raise_on_all_errors=False
        ) as client:
            return (await client.post("/flow_runs/")).status_code

    monkeypatch.setattr(base.anyio, "sleep", at_once)
    with temporary_settings({PREFECT_CLIENT_MAX_RETRIES: 0}):
        return asyncio.run(ask())


def test_a_busy_server_is_asked_again_until_it_answers(monkeypatch):
    busy_at_first = answering(chain(repeat(503, 20), repeat(200)), repeat(0.0))
    assert asked(busy_at_first, monkeypatch) == 200


def test_a_server_that_stays_busy_is_given_up(monkeypatch):
    always_busy = answering(repeat(503), chain([0.0, 1.0, 599.0], repeat(601.0)))
    assert asked(always_busy, monkeypatch) == 503


def test_an_error_is_not_asked_again(monkeypatch):
    assert asked(answering(chain([500], repeat(200)), repeat(0.0)), monkeypatch) == 500
