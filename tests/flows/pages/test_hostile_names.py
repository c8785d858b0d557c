"""What others wrote into a recording is text on every page, however it looks."""

import pytest

from flows.pages.answers import PAGES
from flows.pages.parts import Page, View, seen_by
from flows.pages.shell import page_at
from storage.catalogue import results, runs
from storage.home import Home
from tests.drafts import calibration_of, recording_of
from tests.flows.pages.laid_out import components

NAME = "<script>alert(1)</script><img src=x onerror=alert(1)>\"'`{}\U0001f600../../" + "x" * 10_000
AS_CODE = {"Markdown", "DangerouslySetInnerHTML", "Script", "Iframe", "ObjectEl", "Embed"}
PUT = ("dangerously_allow_html", "dangerouslySetInnerHTML", "dangerously_allow_code")


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> tuple[Home, str]:
    """A store of one run whose unit has that name, and the run's id."""
    home = Home(tmp_path_factory.mktemp("hostile"))
    run, _ = runs.add(recording_of(NAME), home)
    results.save(calibration_of(run), home)
    return home, run.id


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_name_is_text_and_no_part_of_the_page(store: tuple[Home, str], page: Page) -> None:
    home, run = store
    asked = {"run": f"?id={run}", "signals": f"?run={run}", "unit": "?id=1",
             "budget": f"?run={run}&item=gyro_bias&element=x"}  # fmt: skip
    for search in {asked.get(page.name, ""), f"?id={NAME}", f"?serial={NAME}"}:
        shown, _, _ = seen_by(View(), page_at, f"/{page.name}", search, home)
        found = [each.to_plotly_json() for each in components(shown)]
        assert found
        assert not AS_CODE & {part["type"] for part in found}
        assert not [part for part in found for name in PUT if part["props"].get(name)]
        links = [str(part["props"].get("href", "")) for part in found]
        assert all(link == "" or link.startswith("/") for link in links)


def test_the_name_stands_whole_where_the_unit_is_named(store: tuple[Home, str]) -> None:
    home, run = store
    for address in (("/run", f"?id={run}"), ("/unit", "?id=1"), ("/unit", "")):
        shown, _, _ = seen_by(View(), page_at, *address, home)
        assert NAME[:60] in str(shown.to_plotly_json()).replace("\\'", "'")
