"""The endpoints of the pages with random questions, and a PostgreSQL that stops under them."""

import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import httpx

from storage.catalogue import database
from storage.home import Home
from tests.drafts import draft
from tests.pages_server import served
from tests.postgres import empty_database, serving
from tests.proof.report import publish

CHECKS = (
    "not_a_server_error,status_code_conformance,content_type_conformance,"
    "response_schema_conformance"
)
UNITS = 3
BACK_WITHIN_S = 30.0
TEXT = """# The endpoints of the operations pages

`make prove ARGS="--pages {count} --seed {seed}"`: schemathesis asks every endpoint of the OpenAPI
description, {count} random questions each and beside them every edge of its parameters; no answer
may be an error of the server, or another than the description says.

| questions | answered as described | seconds |
|---:|---:|---:|
| {asked} | {passed} | {seconds:.0f} |

A PostgreSQL that is stopped under the pages: the JSON answers {stopped}, the frame of the pages
{frame}, and {back:.1f} s after its start the same question is answered again.
"""


@dataclass(frozen=True)
class Fuzzed:
    """How many questions were asked, and how many were answered as described."""

    asked: int
    passed: int
    seconds: float


@dataclass(frozen=True)
class Stopped:
    """What JSON and frame answer without a database, and after how many seconds it is back."""

    json: int
    frame: int
    back_s: float


def fuzz(address: str, count: int, seed: int) -> Fuzzed:
    """Random questions to every endpoint."""
    began = time.monotonic()
    command = [
        str(Path(sys.executable).with_name("schemathesis")), "--no-color", "run",
        f"{address}/api/v1/openapi.json", f"--max-examples={count}", f"--seed={seed}",
        f"--checks={CHECKS}",
    ]  # fmt: skip
    ended = subprocess.run(command, capture_output=True, text=True)
    found = re.search(r"(\d+) generated, (?:.*?)(\d+) passed", ended.stdout)
    if ended.returncode or found is None:
        print(ended.stdout, ended.stderr)
    asked, passed = (int(each) for each in found.groups()) if found else (0, 0)
    return Fuzzed(asked, passed if not ended.returncode else 0, time.monotonic() - began)


def stop_the_database(folder: Path) -> Stopped:
    """The pages on a PostgreSQL that is stopped, and started again."""
    home = Home(folder / "home")
    with serving() as server:
        os.environ["MIMUCAL_DATABASE"] = empty_database(server.connection)
        try:
            with database.changing(home):
                pass
            with served(home) as address:
                return _stopped(address, server.stop, server.start)
        finally:
            del os.environ["MIMUCAL_DATABASE"]


def _stopped(address: str, stop: Callable[[], None], start: Callable[[], None]) -> Stopped:
    asked = f"{address}/api/v1/runs"
    httpx.get(asked).raise_for_status()
    stop()
    refused = httpx.get(asked).status_code
    frame = httpx.get(f"{address}/runs", headers={"Accept": "text/html"}).status_code
    start()
    began = time.monotonic()
    while httpx.get(asked).status_code != httpx.codes.OK:
        if time.monotonic() - began > BACK_WITHIN_S:
            break
        time.sleep(0.1)
    return Stopped(refused, frame, time.monotonic() - began)


def run_pages(count: int, seed: int, write: bool) -> None:
    """Hold it and print the page; exit 1 where something is wrong. write: into the evidence."""
    with tempfile.TemporaryDirectory(prefix="mimucal-pages-") as name:
        home = Home(Path(name) / "fuzzed")
        for unit in range(UNITS):
            draft(home, f"V{unit}")
        with served(home) as address:
            fuzzed = fuzz(address, count, seed)
        stopped = stop_the_database(Path(name))
    page = TEXT.format(
        count=count, seed=seed, asked=fuzzed.asked, passed=fuzzed.passed, seconds=fuzzed.seconds,
        stopped=stopped.json, frame=stopped.frame, back=stopped.back_s,
    )  # fmt: skip
    as_stated = stopped.json == 503 and stopped.frame == 200 and stopped.back_s < BACK_WITHIN_S
    holds = 0 < fuzzed.asked == fuzzed.passed and as_stated
    publish("pages.md", page, write, not holds)
