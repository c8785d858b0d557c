"""The frame that every page stands in, and its JSON."""

import gzip

import pytest
from flask.testing import FlaskClient

from flows.pages.answers import PAGES
from flows.pages.app import CELLS, GRID, UNUSED, make_app
from storage.home import Home
from tasks.words import known


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> FlaskClient:
    return make_app(Home(tmp_path_factory.mktemp("home"))).server.test_client()


def test_every_page_has_its_words_and_an_endpoint_that_openapi_describes(
    client: FlaskClient,
) -> None:
    described = client.get("/api/v1/openapi.json").json
    for page in PAGES:
        assert known(f"pages-{page.name}")
        assert known(f"pages-{page.name}.about")
        operation = described["paths"][f"/api/v1/{page.name}"]["get"]
        content = operation["responses"]["200"]["content"]["application/json"]
        assert content["schema"]["$ref"].endswith(f"/{page.answer.__name__}")
        assert page.answer.__name__ in described["components"]["schemas"]


def test_openapi_describes_every_address_that_answers_and_no_other(client: FlaskClient) -> None:
    described = client.get("/api/v1/openapi.json").json["paths"]
    served = {
        (rule.rule, method.lower())
        for rule in client.application.url_map.iter_rules()
        if rule.rule.startswith("/api/v1/") and not rule.rule.endswith("openapi.json")
        for method in (rule.methods or set()) - {"HEAD", "OPTIONS"}
    }
    assert {(path, method) for path, each in described.items() for method in each} == served


def test_nothing_on_the_first_document_comes_from_elsewhere(client: FlaskClient) -> None:
    document = client.get("/runs")
    assert 'src="http' not in document.text
    assert 'href="http' not in document.text
    policy = document.headers["Content-Security-Policy"]
    assert "default-src 'self'" in policy
    assert "http" not in policy
    assert document.headers["X-Frame-Options"] == "DENY"


def test_a_page_with_a_grid_asks_for_the_grids_script_at_once(client: FlaskClient) -> None:
    document = client.get("/runs").text
    assert CELLS in document.partition("</head>")[0]
    assert client.get(CELLS.partition('src="')[2].partition('"')[0]).status_code == 200
    grid = GRID.search(document)
    assert grid is not None
    for path in ("/line", "/unit?id=1"):
        without = client.get(path).text
        assert CELLS not in without
        assert GRID.search(without) is None
        assert f'data-grid="{grid[1]}"' in without
    assert UNUSED not in document
    assert "/polyfill@" in document  # dash's own components call its regeneratorRuntime


def test_scripts_and_answers_are_compressed_for_a_browser_and_whole_for_a_script(
    client: FlaskClient,
) -> None:
    grid = GRID.search(client.get("/runs").text)
    assert grid is not None
    for path in (grid[1], "/api/v1/openapi.json"):
        whole, packed = client.get(path), client.get(path, headers={"Accept-Encoding": "gzip"})
        assert "Content-Encoding" not in whole.headers
        assert gzip.decompress(packed.data) == whole.data
        assert len(packed.data) < len(whole.data) / 3
        assert packed.headers["Vary"] == "Accept-Encoding"


def test_language_and_theme_are_those_of_the_cookies_else_the_browsers(client: FlaskClient) -> None:
    first = client.get("/runs", headers={"Accept-Language": "zh-CN,zh;q=0.9"})
    assert '<html lang="zh"' in first.text
    client.set_cookie("mimucal_language", "en")
    client.set_cookie("mimucal_theme", "dark")
    chosen = client.get("/runs", headers={"Accept-Language": "zh-CN"})
    assert '<html lang="en"' in chosen.text
    assert 'data-mantine-color-scheme="dark"' in chosen.text


def test_a_question_that_cannot_be_answered_is_refused_with_a_sentence(client: FlaskClient) -> None:
    refused = client.get("/api/v1/runs?start=x")
    assert refused.status_code == 400
    assert refused.json["error"].startswith("start: ")
    assert client.get("/api/v1/runs?no_such=1").status_code == 400


@pytest.mark.parametrize("path", ["", "/", "/nothing", "/line/more", "/stop"])
def test_an_unknown_address_of_the_api_is_no_page(client: FlaskClient, path: str) -> None:
    answer = client.get(f"/api/v1{path}")
    assert (answer.status_code, answer.mimetype) == (404, "application/json")
