"""Stop in a browser: one press stops the station, also while the page is being renewed."""

import json
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import pytest

from flows.pages import login
from schemas.access import Visitor
from schemas.station import StopRequest
from storage.home import Home
from storage.stations import lock_out, lockout_of
from tests.pages_server import served
from tests.tasks.station.sample_stations import sample
from tests.watched_page import watched_page

pytestmark = [pytest.mark.real_time, pytest.mark.rehearsal]
RENEWALS_S = 2.5  # within which the page is asked for again
PRESSED, FAR_PX = (".release", ".stop"), 60
SMALL = """() => [...document.querySelectorAll('button, .mantine-Input-input, .header-link')]
    .filter((each) => each.offsetParent && !each.closest('.mantine-Input-section'))
    .map((each) => [each.textContent, each.getBoundingClientRect().height])
    .filter(([, height]) => height < 44)"""  # px


@pytest.fixture(scope="module")
def pressed_at() -> list[tuple[str, str, datetime]]:
    return []


@pytest.fixture(scope="module")
def faults() -> list[str]:
    return []


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Home:
    return Home(tmp_path_factory.mktemp("stop"))


@pytest.fixture(scope="module")
def page(home: Home, pressed_at: list[Any], faults: list[str]) -> Iterator[Any]:
    (home.path / "stations").mkdir()
    for id_ in ("S1", "S.2 <b>"):
        fields = sample("mimucal")
        fields["station"]["id"] = id_
        (home.path / "stations" / f"{id_[:2]}.json").write_text(json.dumps(fields))

    def stop(station: str, by: str, _: Home) -> None:
        pressed_at.append((station, by, datetime.now(UTC)))
        raise OSError("the table's cable is out")

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("flows.pages.line_data.stop_station", stop)
        operator = Visitor(name="Wang", role="operator")
        patch.setattr(login, "_identified", lambda *_: operator)
        with served(home) as address, watched_page(address, faults, "en-GB") as page:
            page.goto(f"{address}/line")
            page.wait_for_selector(".stop >> nth=1")
            yield page


def test_one_press_stops_that_station_and_says_what_became_of_it(page, pressed_at, faults) -> None:
    before = len(pressed_at)
    page.click(".station:has-text('S.2 <b>') .stop")
    page.wait_for_selector(".station:has-text('S.2 <b>') >> text=emergency stop", timeout=20_000)
    assert [each[:2] for each in pressed_at[before:]] == [("S.2 <b>", "Wang")]
    time.sleep(RENEWALS_S)
    said = page.locator(".station:has-text('S.2 <b>') >> text=the table's cable is out")
    assert said.count() == 1  # and it stays
    assert faults == []


def test_release_is_asked_and_everything_is_large_enough_for_a_glove(page, home, faults) -> None:
    request = StopRequest(key="k", station="S1", by="Li", at=datetime.now(UTC))
    lock_out(request, home)
    page.wait_for_selector(".release")
    boxes = [page.locator(f".station:has-text('S1') {one}").bounding_box() for one in PRESSED]
    release, stop = (box["y"] for box in boxes)
    assert stop - release - boxes[0]["height"] > FAR_PX
    page.click(".release")
    page.click(".asking .no")
    assert page.locator(".release").count() == 1
    page.click(".release")
    page.wait_for_selector(".asking >> text=Is nobody within reach of the table of S1?")
    page.wait_for_timeout(1000 * RENEWALS_S)  # the question stays, and Stop can be pressed
    assert page.locator(".stop >> nth=0").is_enabled()
    page.click(".asking .yes")
    page.wait_for_selector(".release", state="detached")
    assert lockout_of("S1", home) is None
    for path in ("line", "do"):
        page.goto(f"{page.url.rsplit('/', 1)[0]}/{path}")
        page.wait_for_selector("#page h2")
        page.wait_for_timeout(500)
        assert page.evaluate(SMALL) == []
    page.goto(f"{page.url.rsplit('/', 1)[0]}/line")
    page.wait_for_selector(".stop >> nth=1")
    assert faults == []


def test_a_press_that_is_held_while_the_page_is_renewed_stops_all_the_same(
    page, pressed_at, faults
) -> None:
    before = len(pressed_at)
    button = page.locator(".station:has-text('S1') .stop")
    button.scroll_into_view_if_needed()
    box = button.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    time.sleep(RENEWALS_S)
    page.mouse.up()
    deadline = time.monotonic() + 10
    while len(pressed_at) == before and time.monotonic() < deadline:
        page.wait_for_timeout(100)
    assert [each[0] for each in pressed_at[before:]] == ["S1"]
    assert faults == []
