"""Every page of a store as pictures: both languages and themes, on a desktop and on a tablet."""

import time
from base64 import b64encode
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING

import sqlalchemy as sql

from flows.pages.register import PAGES
from schemas.base import Unusable
from storage.catalogue import tables
from storage.catalogue.database import rows
from storage.home import Home
from tests.pages_server import served
from tests.proof.line.run import make_line
from tests.proof.line.store import recorded_runs

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

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


def run_screens(seed: int, count: int, out: Path | None) -> None:
    """PNGs of every page of a line with so many runs, which is made in `store` of the folder unless
    it is there. Unusable where a page logs an error or asks another host.
    """
    folder = (out or Path(f"proof-screens-{seed}")).absolute()
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
