"""A further language is a folder: a pseudo-language goes through everything that people read."""

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from lxml import html

from flows.pages.answers import PAGES
from flows.pages.parts import View, seen_by
from flows.pages.shell import page_at
from flows.shown_results import print_calibration, print_discrepancy
from schemas.certificate import Certificate
from storage.catalogue import certificates, results
from storage.catalogue.certificates import record_of
from storage.catalogue.run_states import run_list
from storage.home import Home
from tasks.certificate.content import content, in_languages
from tasks.certificate.dcc import dcc_of
from tasks.certificate.pdf import render
from tasks.explain.explanation import Explanation
from tasks.explain.report import write_report
from tasks.model.term import effect_name
from tasks.stages.explain import Explained
from tasks.words import MAIN
from tests.flows.pages.laid_out import texts
from tests.pseudo_language import phrases, spoken
from tests.storage.full_home import fill
from tests.tasks.explain.report import made_report

# What the home's own people have written.
OWN = {
    "The table is tilted", "no answer", "run of", "Head of laboratory", "new version", "test ideal",
    "Data sheet", "body kinematics", "is up",
}  # fmt: skip
# The lines of budgets are made in a validated room that keeps no message yet.
UNSAID = {
    "table rate over whole turns", "table rate within", "rate held", "against the rate commanded",
    "the station file", "how well the table holds", "commanded rate",
}  # fmt: skip


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Home:
    made = Home(tmp_path_factory.mktemp("pseudo") / "home")
    fill(made)
    return made


@pytest.fixture
def language(tmp_path: Path) -> Iterator[str]:
    folder = tmp_path / "words"
    folder.mkdir()
    with spoken(folder) as name:
        yield name


@pytest.fixture
def certificate(home: Home) -> Certificate:
    entries = certificates.register(home)
    record = record_of(next(each for each in entries if each.state == "issued"), home)
    return record.model_copy(update={"budgets": True})


def test_the_terminal_says_of_results_what_the_catalogues_have(
    home: Home, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "1000")
    explained = partly_explained()
    found = Explained(made_report.answer(explained, (), ()))
    with spoken(tmp_path, MAIN):
        for line in run_list([], [], 0, 9, home)[1]:
            print_calibration(results.find(line.id, home).calibration)
        print_discrepancy(found)
    shown = capsys.readouterr().out
    assert "⟦" in shown
    assert phrases([shown]) - OWN == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_page_speaks_a_further_language(page: Any, home: Home, language: str) -> None:
    made = [results.find(line.id, home) for line in run_list([], [], 0, 9, home)[1]]
    run, item, element = next(
        (result.run, name, element)
        for result in made
        for name, item in result.calibration.items.items()
        for element in item.budgets
    )
    asked = {
        "run": f"?id={run}", "signals": f"?run={run}", "unit": "?id=1",
        "budget": f"?run={run}&item={item}&element={element}",
    }  # fmt: skip
    shown, _, _ = seen_by(View(language), page_at, f"/{page.name}", asked.get(page.name, ""), home)
    said = list(texts(shown))
    assert any("⟦" in text for text in said)
    assert phrases(said) - OWN - UNSAID == set()


def test_a_certificate_speaks_a_further_language(certificate: Certificate, language: str) -> None:
    printed = asdict(in_languages(content(certificate), (language,)))
    said = list(texts(printed))
    assert len(said) > 250
    assert phrases(said) - OWN == set()
    assert render(certificate, (language,)).startswith(b"%PDF")


def test_a_digital_certificate_speaks_every_language(
    certificate: Certificate, language: str
) -> None:
    root = ElementTree.fromstring(dcc_of(certificate))
    contents = [each for each in root.iter("{https://ptb.de/dcc}content") if each.text]
    written = [each.text or "" for each in contents if each.get("lang") == language]
    assert len(written) == len(contents) / 3
    assert phrases(written) - OWN == set()


def partly_explained() -> Explanation:
    found = made_report.finding(title=effect_name("axis_tilt"), indistinguishable=("axis_wobble",))
    return made_report.explanation(found, made_report.unnamed(), verdict="partly_explained")


def test_a_report_and_its_pictures_speak_a_further_language(tmp_path: Path, language: str) -> None:
    explained = partly_explained()
    answer = made_report.answer(explained, (made_report.BIAS,), (made_report.CHANGE,))
    write_report(answer, explained, tmp_path / "report")
    page = html.parse(str(tmp_path / "report" / "report.html")).getroot()
    for each in page.xpath(
        f"//head | //script | //style | //*[@lang and @lang != '{language}' and not(self::html)]"
    ):
        each.drop_tree()
    assert phrases(page.itertext()) - OWN == set()
    for name in ("where", "before_after", "shares"):
        svg = ElementTree.parse(tmp_path / "report" / f"{name}-{language}.svg").getroot()
        written = [
            "".join(each.itertext()) for each in svg.iter("{http://www.w3.org/2000/svg}text")
        ]
        assert any("⟦" in text for text in written)
        assert phrases(written) - OWN == set()
        assert (tmp_path / "report" / f"{name}.svg").is_file()
