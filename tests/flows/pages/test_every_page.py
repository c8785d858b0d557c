"""What holds of every page: words of the reader's language, no command of a shell, colours that are
read, and one Chinese term for one thing.
"""

import json
import re
from collections.abc import Iterator
from datetime import UTC, date, datetime
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from flows.pages import discrepancy as discrepancy_page
from flows.pages import due, quality, unit
from flows.pages.do import answer, chosen
from flows.pages.parts import View, seen_by
from flows.pages.shell import page_at
from schemas.access import Visitor
from schemas.station import StopRequest
from schemas.text import Remark
from storage.catalogue import certificates, discrepancies, equipment, orders, results, runs
from storage.home import Home
from storage.stations import lock_out, write_status
from tests.drafts import calibration_of, draft, recording_of
from tests.flows.pages.laid_out import texts
from tests.flows.pages.test_discrepancy import discrepancy
from tests.flows.pages.test_line import ordered, status

CAUSE = "the drive of axis 2 tripped; see /srv/home/logs/T1.log, then run `mimucal station check`"
SENTENCE = re.compile(r"[A-Za-z]{2,}(?:[ ,;:]+[A-Za-z']{2,}){3,}")  # four English words in a row
OF_SHELL = re.compile(r"`|\bmimucal [a-z]|/srv/|(?<!\w)--[a-z]")
ADMINISTRATOR = Visitor(name="Wang", role="administrator")
WORDS = files("tasks.words")
NOW = datetime.now(UTC)


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Home:
    """A bad day: all that can be wrong on the line, with causes as earlier versions wrote them."""
    home = Home(tmp_path_factory.mktemp("day"))
    draft(home, "1")
    run, _ = runs.add(recording_of("2"), home)
    invalid = Remark(en="Said.", zh="说。", code="clock", run="invalid")
    results.save(calibration_of(run, remarks=(invalid,)), home)
    discrepancies.keep(run, discrepancy("axis_tilt"), "<p>", NOW, home)
    write_status(status(state="stopped", cause=CAUSE), home)
    lock_out(StopRequest(key="k", station="T1", by="Li", at=NOW), home)
    orders.add([ordered("A-1"), ordered("A-2", "T2", "V8")], home)
    orders.claim("A-1", home)
    orders.finish("A-1", "failed", home, CAUSE)
    orders.note("A-2", home, fault=CAUSE)
    key = (next(iter(_drafts(home))), -30, "mail")
    equipment.claim(home, key, NOW, lambda tries: NOW - NOW)
    equipment.note(home, key, NOW, CAUSE)
    (home.path / "stations").mkdir()
    (home.path / "stations" / "broken.toml").write_text("format = 1", encoding="utf-8")
    return home


def _drafts(home: Home) -> Iterator[str]:
    yield from (entry.number for entry in certificates.register(home))


@pytest.mark.parametrize("language", ["en", "zh"])
@pytest.mark.parametrize(
    "name", ["line", "do", "mismatch", "quality", "run", "unit", "runs", "due"]
)
@pytest.mark.parametrize("is_empty", [False, True])
def test_a_page_has_neither_another_language_nor_a_command(
    home: Home, tmp_path: Path, name: str, language: str, is_empty: bool
) -> None:
    asked = {"run": ["?id=run of 2", "?id=none"], "unit": ["", "?id=1", "?id=9"],
             "quality": ["", "?model=none"]}.get(name, [""])  # fmt: skip
    view = View(language, visitor=ADMINISTRATOR)
    for search in asked:
        page, _, _ = seen_by(
            view, page_at, f"/{name}", search, Home(tmp_path) if is_empty else home
        )
        shown = list(texts(page))
        assert shown
        assert [text for text in shown if OF_SHELL.search(text)] == []
        assert language == "en" or [text for text in shown if SENTENCE.search(text)] == []


ASKED = [
    (discrepancy_page, {}), (due, {"within": 7}), (due, {"client": "nobody"}), (unit, {"id": 1}),
    (quality, {"model": "MX-110", "since": date(2100, 1, 1)}),
    (quality, {"model": "MX-110", "plot": "change", "station": "ST-01"}),
]  # fmt: skip


@pytest.mark.parametrize("language", ["en", "zh"])
@pytest.mark.parametrize(("page", "asked"), ASKED)
def test_a_page_of_the_line_is_laid_out_and_its_json_is_json(
    line_store, page: Any, asked: dict[str, object], language: str
) -> None:
    question = page.PAGE.question.model_validate(asked)
    shown = page.PAGE.data(question, line_store[0])
    json.loads(shown.model_dump_json(), parse_constant=pytest.fail)
    assert seen_by(View(language), page.PAGE.layout, shown, question).to_plotly_json()


def test_what_is_refused_on_the_page_do_is_said_in_the_readers_language(home: Home) -> None:
    number = next(_drafts(home))
    operator = View("zh", visitor=Visitor(name="Li", role="operator"))
    drafter = View("zh", visitor=ADMINISTRATOR)
    refusals = [
        seen_by(operator, answer, "issue", {}, home), seen_by(drafter, answer, "check", {}, home),
        seen_by(drafter, answer, "check", {"certificate": number}, home),
        seen_by(drafter, answer, "issue", {"certificate": number}, home),
        seen_by(drafter, answer, "certify", {"run": "none"}, home),
        seen_by(drafter, chosen, "check", "none", home),
    ]  # fmt: skip
    for each in refusals:
        words = " ".join(texts(each))
        assert not SENTENCE.search(words)
        assert "日志" not in words  # the cause itself


def test_no_word_of_the_pages_is_a_command() -> None:
    for language in ("en", "zh"):
        for name in ("pages", "line_page", "reminders", "review"):
            text = (WORDS / language / f"{name}.ftl").read_text(encoding="utf-8")
            assert "`" not in text


def test_one_thing_has_one_chinese_name() -> None:
    """The list stands at the head of the pages' words."""
    lines = (WORDS / "zh" / "pages.ftl").read_text(encoding="utf-8").splitlines()
    listed = "".join(line.removeprefix("## ") for line in lines if line.startswith("## "))
    others = [
        word for inside in re.findall("（([^）]+)）[，。]", listed) for word in inside.split("、")
    ]
    assert len(others) > 15
    for name in ("pages", "line_page", "station", "review", "reminders"):
        text = (WORDS / "zh" / f"{name}.ftl").read_text(encoding="utf-8")
        words = "\n".join(line for line in text.splitlines() if not line.startswith("#"))
        assert [(name, word) for word in others if word in words] == []


def luminance(colour: str) -> float:
    """WCAG 2.2 of “#rrggbb”."""
    channels = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_every_colour_is_read_on_its_ground_as_wcag_aa_asks(theme: str) -> None:
    style = (files("flows.pages") / "assets" / "pages.css").read_text(encoding="utf-8")
    blocks = re.findall(r"html:root[^{]*\{([^}]*)\}", style)
    common, own = blocks[2], blocks[0 if theme == "light" else 1]
    colours = dict(re.findall(r"(--[\w-]+): (#\w{6});", own + common))
    names = [name for name in colours if not name.endswith("-back") and "mantine" not in name]
    assert len(names) > 15
    for name in names:
        if name != "--page":
            ground = colours.get(f"{name}-back", colours["--page"])
            light, dark = sorted(map(luminance, (colours[name], ground)), reverse=True)
            assert (light + 0.05) / (dark + 0.05) >= 4.5, name
    assert "--mantine-color-dimmed: var(--note)" in common
    login = style.index(".login {"), style.index(".leave {")
    rules = style[style.rindex("html:root") : login[0]] + style[login[1] :]
    assert re.findall(r"(?<![-\w])color: (?!var\(--|inherit)[^;]*", rules.split("}", 1)[1]) == []
