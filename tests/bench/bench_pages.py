"""The operations pages on ten thousand runs: first paint, content, a filter, twenty people at once.

Wall time, of the command as it is started, in Debian's chromium where that is installed.
"""

import os
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from shutil import which
from statistics import median, quantiles
from typing import TYPE_CHECKING

from storage.home import Home
from tests.bench.measure import RUNS, Figure, Section
from tests.proof.line import LINE_UNITS, Recorded, draw_line, fill

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

PAINT_S, FILTER_S, PEOPLE_S = 1.0, 0.5, 1.0  # asked
GRID_PAUSE_S = 0.5  # for which the grid itself waits for a further letter
SEED, COUNT = 1, 10_000
PEOPLE, LOOKS, LOOK_S = 20, 10, 1.0
PATHS = ("/api/v1/runs?station=ST-03", "/api/v1/runs?verdict=fail&sort=due", "/api/v1/line",
         "/api/v1/runs?validity=invalid", "/runs", "/api/v1/due", "/api/v1/unit?id=7",
         "/api/v1/unit?search=0042", "/api/v1/quality?model=MX-110")  # fmt: skip
FIRST_SEEN = {
    "/runs": ".ag-cell a", "/line": "#page h3", "/do": "#page h3", "/unit": ".ag-cell a",
    "/unit?id=7": "#page table", "/due": "#page h3",
    "/quality": "#page h3", "/mismatch": "#page h3",
}  # fmt: skip
FILTERS = (
    "/api/v1/due?client=North%20Works&within=365", "/api/v1/unit?id=7&item=accel_bias",
    "/api/v1/quality?model=MX-120&item=accel_rate_sensitivity&element=xy&station=ST-02",
    "/api/v1/mismatch?station=ST-02",
)  # fmt: skip
FIRST_PAINT_MS = "performance.getEntriesByName('first-contentful-paint')[0].startTime"
OPTIONS = ["--no-sandbox", "--disable-gpu", "--no-proxy-server", "--disable-dev-shm-usage"]


def pages() -> Section:
    """What is asked is the first line; each other one is to be no more than its share of it."""
    with tempfile.TemporaryDirectory() as name:
        home = Home(Path(name) / "line")
        fill(home, draw_line(SEED, COUNT, LINE_UNITS), Recorded(0), lambda *_: None)
        with dashboard(home) as address:
            figures = [*_in_browser(address), *_answers(address), _people(address)]
    return Section(
        "Operations pages on 10,000 runs (wall)",
        (Figure("asked of a first paint", PAINT_S), *figures),
        "First paint: as the browser reports it (first contentful paint). Content: from the "
        "address to the first row or heading of the page itself. Medians of 5. A filter: from the "
        "last letter to its rows, without the 0.5 s for which the grid waits for another. Twenty "
        "people, each asking every second.",
    )


@contextmanager
def dashboard(home: Home) -> Iterator[str]:
    """The address of `mimucal dashboard` on a free port, in a process of its own."""
    command = [sys.executable, "-m", "flows.cli", "dashboard", "--port", "0"]
    environment = os.environ | {"MIMUCAL_HOME": str(home.path)}
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as serving:
        assert serving.stdout is not None
        try:
            yield serving.stdout.readline().split()[0].rstrip("/")
        finally:
            serving.terminate()  # SIGINT is ignored by what a shell started in its background


def _in_browser(address: str) -> list[Figure]:
    chromium = which("chromium")
    if chromium is None:
        return []
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=OPTIONS)
        figures = [
            figure
            for path, found in FIRST_SEEN.items()
            for figure in _paint(browser, f"{address}{path}", path, found)
        ]
        figures.append(_filter(browser.new_page(), f"{address}/runs"))
        browser.close()
    return figures


def _paint(browser: "Browser", url: str, path: str, found: str) -> Iterator[Figure]:
    paints, empty, full = [], [], []
    for _ in range(RUNS):
        context = browser.new_context()
        page = context.new_page()
        for times in (empty, full):
            began = time.perf_counter()
            page.goto(url, wait_until="commit")
            page.wait_for_selector(found)
            times.append(time.perf_counter() - began)
            if times is empty:
                paints.append(1e-3 * page.evaluate(FIRST_PAINT_MS))
        context.close()
    yield Figure(f"{path}, first paint, empty cache", median(paints), asked=1.0)
    yield Figure(f"{path}, content, empty cache", median(empty), asked=1.0)
    yield Figure(f"{path}, content, full cache", median(full), asked=1.0)


def _filter(page: "Page", url: str) -> Figure:
    page.goto(url)
    page.wait_for_selector(FIRST_SEEN["/runs"])
    times = []
    for number in range(RUNS):
        began = time.perf_counter()
        page.fill("[aria-colindex='5'] input[type=text] >> visible=true", f"SN010{number}")
        page.wait_for_selector("#runs-count:text-is('50 runs')")
        page.wait_for_selector(f".ag-cell:has-text('SN010{number}')")
        times.append(time.perf_counter() - began - GRID_PAUSE_S)
    return Figure("a filter of the runs", median(times), asked=FILTER_S / PAINT_S)


def _answers(address: str) -> Iterator[Figure]:
    for path in FILTERS:
        times = []
        for _ in range(RUNS):
            began = time.perf_counter()
            urllib.request.urlopen(address + path).read()
            times.append(time.perf_counter() - began)
        name = path.partition("?")[0]
        yield Figure(f"a filter of {name}", median(times), asked=FILTER_S / PAINT_S)


def _people(address: str) -> Figure:
    def look(person: int) -> list[float]:
        times = []
        for step in range(LOOKS):
            began = time.perf_counter()
            urllib.request.urlopen(address + PATHS[(person + step) % len(PATHS)]).read()
            times.append(time.perf_counter() - began)
            time.sleep(LOOK_S)
        return times

    with ThreadPoolExecutor(PEOPLE) as everybody:
        times = [each for one in everybody.map(look, range(PEOPLE)) for each in one]
    return Figure("20 people at once, 95th percentile", quantiles(times, n=20)[-1], asked=PEOPLE_S)
