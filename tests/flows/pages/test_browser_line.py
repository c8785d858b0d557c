"""Quality and Mismatch of a line in a browser: opened, filtered, and down to single runs."""

import shutil
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import pytest

from schemas.discrepancy import KeptReview
from storage import dataframes, run_statistics
from storage.catalogue import discrepancies, runs
from storage.home import Home
from tests.flows.pages.test_discrepancy import discrepancy, review
from tests.pages_server import served
from tests.proof.line import Line
from tests.watched_page import watched_page

pytestmark = [pytest.mark.real_time, pytest.mark.rehearsal]


@pytest.fixture(scope="module")
def kept(
    line_store: tuple[Home, Line], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Home, str]:
    """The line, with a station that a review found tilted and one run that shows it; that run."""
    home = Home(tmp_path_factory.mktemp("browser") / "home")
    shutil.copytree(line_store[0].path, home.path)
    table = dataframes.runs(home).sort_values("recorded_on")
    run = str(table[table["station"] == "ST-01"]["id"].iloc[-1])
    at = datetime(2026, 11, 1, tzinfo=UTC)
    discrepancies.keep(runs.find(run, home), discrepancy("axis_tilt"), "<p>told</p>", at, home)
    found: KeptReview = review("station", "ST-01", "2025-01-05T08:00", "2024-11-01T08:00")
    run_statistics.keep_review(found, home)
    return home, run


@pytest.fixture(scope="module")
def faults() -> list[str]:
    return []


@pytest.fixture(scope="module")
def page(kept: tuple[Home, str], faults: list[str]) -> Iterator[Any]:
    with served(kept[0]) as address, watched_page(address, faults, "en-GB") as page:
        page.goto(address)
        yield page


def test_quality_is_filtered_and_a_point_of_its_chart_opens_its_run(page, faults) -> None:
    page.click("header a:has-text('Quality')")
    for choice, chosen in (("model", "MX-120"), ("station", "ST-02")):
        page.click(f"""[id*='"asks":"{choice}"']""")
        page.click(f"[role=option]:has-text('{chosen}') >> visible=true")
        page.wait_for_url(f"**{choice}={chosen}**")
        page.reload()  # the address keeps what was chosen; a page that changes closes its lists
        page.wait_for_selector("#quality-chart .scatterlayer .points path")
    point = page.locator("#quality-chart .scatterlayer .points path").first
    point.scroll_into_view_if_needed()
    drawn = point.bounding_box()
    across, down = drawn["x"] + drawn["width"] / 2, drawn["y"] + drawn["height"] / 2
    page.mouse.move(across, down)
    page.wait_for_selector("#quality-chart .hovertext")
    page.mouse.click(across, down)
    page.wait_for_url("**/run?id=*")
    page.wait_for_selector("#run-tabs")
    assert faults == []


def test_discrepancy_leads_from_the_station_to_its_runs_and_from_an_effect_to_its(
    page, kept, faults
) -> None:
    page.click("header a:has-text('Mismatch')")
    page.wait_for_selector(".carried >> text=Station ST-01")
    page.click("a[href='/mismatch?effect=axis_tilt']")
    page.wait_for_url("**/mismatch?effect=axis_tilt")
    page.wait_for_selector(f"table a:has-text('{kept[1]}')")
    rows = page.locator("#page tbody tr").all_inner_texts()
    assert all("mismatch, explained" in row for row in rows)
    page.click(".carried a:has-text('show runs') >> nth=0")
    page.wait_for_url("**/runs?station=ST-01&since=2025-01-05")
    page.wait_for_selector(".ag-cell a")
    stations = page.locator(".ag-cell[col-id=station]").all_inner_texts()
    assert set(stations) == {"ST-01"}
    page.click(f".ag-cell a:has-text('{kept[1]}')")
    page.wait_for_selector("#run-tabs")
    assert faults == []
