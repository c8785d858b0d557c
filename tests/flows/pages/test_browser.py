"""The pages in a browser: what is shown, what is asked of whom, and a database that stops."""

from collections.abc import Iterator
from threading import Event, Thread

import pytest
from werkzeug.serving import make_server

from flows.pages import shell
from flows.pages.app import make_app
from storage.catalogue import database, runs
from storage.home import Home
from tasks.words import LANGUAGES, message, say
from tests.drafts import draft, recording_of
from tests.watched_page import watched_page

HOSTILE = "<img src=x onerror=alert(1)>\"'\U0001f600" + "x" * 10_000

pytestmark = pytest.mark.real_time


@pytest.fixture(scope="module")
def home(tmp_path_factory) -> Home:
    made = Home(tmp_path_factory.mktemp("browser"))
    draft(made, "V1")
    runs.add(recording_of(HOSTILE), made)
    return made


@pytest.fixture(scope="module")
def address(home) -> Iterator[str]:
    server = make_server("127.0.0.1", 0, make_app(home).server, threaded=True)
    Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()


@pytest.fixture(scope="module")
def faults() -> list[str]:
    return []


@pytest.fixture(scope="module")
def page(address, faults) -> Iterator:
    with watched_page(address, faults, "zh-CN") as page:
        yield page


def test_a_run_is_found_filtered_and_opened_in_both_languages(page, address, faults):
    page.goto(f"{address}/runs")
    page.wait_for_selector(".ag-cell a")
    assert page.locator(".ag-center-cols-container [role=row]").count() == 2
    page.fill("[aria-colindex='4'] input[type=text] >> visible=true", "v1")
    page.wait_for_selector("#runs-count:text-is('共 1 条测量记录')")
    page.click(".ag-cell a")
    page.wait_for_selector("#run-tabs")
    assert "0.250 °/s" in page.inner_text("#page")
    page.click("text=English")
    page.wait_for_selector("text=Gyro bias")
    page.click("[role=tab]:has-text('Signals')")
    page.wait_for_selector("#signals-rows:has-text('300 rows')")
    assert faults == []


def test_a_name_with_a_script_is_text(page, address, faults):
    page.goto(f"{address}/runs")
    page.wait_for_selector(f"text={HOSTILE[:28]}")
    assert page.locator("img[src=x]").count() == 0
    assert faults == []


@pytest.mark.rehearsal
def test_a_database_that_stops_is_said_so_and_the_page_comes_back_by_itself(
    page, address, faults, monkeypatch
):
    stopped, reading = Event(), database.rows

    def rows(*asked):
        if stopped.is_set():
            cause = message("station-cause.catalogue")
            raise database.Busy("The catalogue cannot be used (it was stopped).", cause)
        return reading(*asked)

    monkeypatch.setattr(database, "rows", rows)
    monkeypatch.setattr(shell, "RETRY_S", 0.2)
    page.goto(f"{address}/runs")
    page.wait_for_selector(".ag-cell a")
    stopped.set()
    page.click("header a >> nth=0")
    causes = (say(message("station-cause.catalogue"), language) for language in LANGUAGES)
    page.wait_for_selector(", ".join(f".notice:has-text('{cause}')" for cause in causes))
    stopped.clear()
    page.wait_for_selector(".notice", state="detached")
    page.wait_for_selector("#page h2")
    assert faults == []
