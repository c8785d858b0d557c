"""The endpoints of the pages with random questions, and a PostgreSQL that stops under them."""

import os
import re
import subprocess
import sys
import tempfile
import time
from base64 import b64encode
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING

import httpx
import sqlalchemy as sql

from flows.pages.answers import PAGES
from schemas.base import Unusable
from storage.catalogue import database, tables
from storage.catalogue.database import rows
from storage.home import Home
from tests.drafts import draft
from tests.pages_server import served
from tests.postgres import empty_database, serving
from tests.proof.line import recorded_runs
from tests.proof.line_pages import make_line
from tests.proof.study import Count, Out, Seed, Write, folder_of, hold

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page


CHECKS = (
    "not_a_server_error,status_code_conformance,content_type_conformance,"
    "response_schema_conformance"
)
UNITS = 3
BACK_WITHIN_S = 30.0
TEXT = """# The endpoints of the operations pages

`make prove ARGS="pages {count} --seed {seed}"`: schemathesis asks every endpoint of the OpenAPI
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


def pages(count: Count = 300, seed: Seed = 1, out: Out = None, write: Write = False) -> None:
    """Random questions to each endpoint of the pages, and a database that stops under them."""
    hold("pages", {f"{seed}-{count}": count}, partial(_asked, seed=seed),
         lambda found: page(count, seed, *found[0]), out, write=write, at_once=0,
         faults=lambda one: _faults(*one))  # fmt: skip


def _asked(count: int, seed: int) -> tuple[Fuzzed, Stopped]:
    with tempfile.TemporaryDirectory(prefix="mimucal-pages-") as name:
        home = Home(Path(name) / "fuzzed")
        for unit in range(UNITS):
            draft(home, f"V{unit}")
        with served(home) as address:
            fuzzed = fuzz(address, count, seed)
        return fuzzed, stop_the_database(Path(name))


def _faults(fuzzed: Fuzzed, stopped: Stopped) -> Iterator[str]:
    if not 0 < fuzzed.asked == fuzzed.passed:
        yield f"{fuzzed.passed} of {fuzzed.asked} questions were answered as described"
    if (stopped.json, stopped.frame) != (503, 200) or stopped.back_s > BACK_WITHIN_S:
        yield f"without the database: {stopped}"


def page(count: int, seed: int, fuzzed: Fuzzed, stopped: Stopped) -> str:
    return TEXT.format(
        count=count, seed=seed, asked=fuzzed.asked, passed=fuzzed.passed, seconds=fuzzed.seconds,
        stopped=stopped.json, frame=stopped.frame, back=stopped.back_s,
    )  # fmt: skip


# Every page of a store as pictures: both languages and themes, on a desktop and on a tablet.

WIDTHS = {"desktop": (1440, 1000), "tablet": (820, 1100)}
LANGUAGES, THEMES = ("en", "zh"), ("light", "dark")
TABS, SIGNALS = 6, 2  # of the page of a run
COMPOSED = ("unit-one", "due", "run-2", "quality")
SETTLED_MS = 900  # after the last answer, for pictures that are drawn behind the text
DRAWN = """() => [...document.querySelectorAll(`[id*='"type":"picture"}']`)]
    .every((place) => place.querySelector('.main-svg'))"""
ARGUMENTS = (
    "--no-sandbox --disable-gpu --disable-quic --disable-background-networking "
    "--disable-component-update --disable-sync --no-proxy-server --disable-dev-shm-usage"
)


def screens(count: Count = 10_000, seed: Seed = 1, out: Out = None) -> None:
    """PNGs of every page of a line with N runs, made in `store` of the folder unless it is there.

    Unusable where a page logs an error or asks another host.
    """
    folder = folder_of("screens", out)
    home = Home(folder / "store")
    if not home.path.exists():
        make_line(seed, count, home)
    addresses = list(_addresses(home))
    browser_path = which("chromium")
    if browser_path is None:
        raise Unusable("There is no chromium (apt-get install chromium).")
    from playwright.sync_api import sync_playwright

    with served(home) as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path, args=ARGUMENTS.split())
        faults = [
            fault
            for width, language, theme in product(WIDTHS, LANGUAGES, THEMES)
            for fault in _looked_at(browser, address, addresses, folder, (width, language, theme))
        ]
        _composed(browser, folder)
        browser.close()
    print(f"{len(list(folder.glob('*.png')))} pictures in {folder}")
    if faults:
        raise Unusable("; ".join(dict.fromkeys(faults)))


def _addresses(home: Home) -> Iterator[tuple[str, str]]:
    """Name and address of every page, and of those that need one a run and a unit of the store."""
    paper = tables.certificates.c
    issued = {row.run for row in rows(home, sql.select(paper.run).where(paper.state == "issued"))}
    run = next((run for run in recorded_runs(home) if run in issued), None)
    if run is None:
        raise Unusable(f"{home.path} has no recording with a certificate; take another seed.")
    found = rows(home, tables.runs.select().where(tables.runs.c.id == run))
    element = "item=gyro_bias&element=x"
    asked = {
        "run": f"?id={run}", "signals": f"?run={run}", "budget": f"?run={run}&{element}",
    }  # fmt: skip
    for page in PAGES:
        yield page.name, f"/{page.name}{asked.get(page.name, '')}"
    yield "unit-one", f"/unit?id={found[0].unit}"
    yield "nowhere", "/nowhere"


def _looked_at(
    browser: "Browser", address: str, addresses: list[tuple[str, str]], folder: Path,
    look: tuple[str, str, str],
) -> list[str]:  # fmt: skip
    width, language, theme = look
    across, down = WIDTHS[width]
    context = browser.new_context(viewport={"width": across, "height": down})
    context.add_cookies([
        {"name": "mimucal_language", "value": language, "url": address},
        {"name": "mimucal_theme", "value": theme, "url": address},
    ])  # fmt: skip
    page, faults = context.new_page(), list[str]()
    ours = (address, "data:", "blob:")
    page.set_default_timeout(120_000)
    page.on("console", lambda m: faults.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("request", lambda r: None if r.url.startswith(ours) else faults.append(r.url))
    for name, path in addresses:
        page.goto(address + path)
        page.wait_for_selector("#page > *")
        _picture(page, folder / f"{name}-{width}-{language}-{theme}.png")
        if name == "run":
            for tab in range(1, TABS):
                page.click(f"#run-tabs [role=tab] >> nth={tab}")
                page.wait_for_selector(f"#run-tabs [role=tab]:nth-child({tab + 1})[data-active]")
                if tab == SIGNALS:
                    page.wait_for_selector("#signals-rows:not(:empty)")
                _picture(page, folder / f"run-{tab}-{width}-{language}-{theme}.png")
    context.close()
    return [f"{width} {language} {theme}: {fault}" for fault in faults]


def _composed(browser: "Browser", folder: Path) -> None:
    """Four of the pictures as one, `pages.png`."""
    page = browser.new_page(viewport={"width": 1200, "height": 800})
    parts = "".join(
        f'<div style="background:url(data:image/png;base64,{b64encode(data).decode()}) '
        '0 0/600px"></div>'
        for data in ((folder / f"{name}-desktop-en-light.png").read_bytes() for name in COMPOSED)
    )
    style = "margin:0;display:grid;grid:400px 400px/1fr 1fr;gap:2px;background:#888"
    page.set_content(f'<body style="{style}">{parts}')
    page.screenshot(path=folder / "pages.png")


def _picture(page: "Page", path: Path) -> None:
    page.wait_for_load_state("networkidle")
    page.wait_for_function(DRAWN)
    time.sleep(SETTLED_MS / 1000)
    page.screenshot(path=path, full_page=True)
