"""The catalogues say the same things in every language, and what they say with arguments is kept.

After a change of the catalogues: `SENTENCES=renew .venv/bin/pytest tests/tasks/words`, and read
what `git diff` shows of sentences.txt.
"""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from fluent.syntax import ast, parse
from fluent.syntax.visitor import Visitor

from schemas.text import Statement
from tasks.words import LANGUAGES, Message, known, message, say, statement, texts
from tasks.words.translation import _catalogue_file, _file_of, _rendered

WORDS = Path("tasks/words")
SENTENCES = Path(__file__).with_name("sentences.txt")


def entries(language: str) -> Iterator[tuple[str, ast.Message]]:
    for path in sorted((WORDS / language).glob("*.ftl")):
        for entry in parse(path.read_text(encoding="utf-8")).body:
            if isinstance(entry, ast.Message):
                yield path.name, entry


class Arguments(Visitor):
    """The names of the arguments that a message uses."""

    def __init__(self) -> None:
        super().__init__()
        self.names: set[str] = set()

    def visit_VariableReference(self, node: ast.VariableReference) -> None:  # noqa: N802
        self.names.add(node.id.name)


class References(Visitor):
    """The messages that a message refers to."""

    def __init__(self) -> None:
        super().__init__()
        self.names: set[str] = set()

    def visit_MessageReference(self, node: ast.MessageReference) -> None:  # noqa: N802
        self.names.add(node.id.name)


class Choices(Visitor):
    """By argument, the values among which a message chooses what it says."""

    def __init__(self) -> None:
        super().__init__()
        self.values: dict[str, list[str]] = {}

    def visit_SelectExpression(self, node: ast.SelectExpression) -> None:  # noqa: N802
        asked = Arguments()
        asked.visit(node.selector)
        keys = [variant.key for variant in node.variants]
        named = [key.name if isinstance(key, ast.Identifier) else key.value for key in keys]
        for name in asked.names:
            known_ = self.values.setdefault(name, [])
            known_ += [key for key in named if key not in known_]
        self.generic_visit(node)


def sample(name: str, choices: list[str], chosen: str | None) -> str | int:
    """An argument: its name in brackets, or a value by which the message chooses."""
    if choices and set(choices) <= {"zero", "one", "two", "few", "many", "other", "0", "1"}:
        return {"zero": 0, "0": 0, "one": 1, "1": 1}.get(chosen or "other", 5)
    return f"‹{name}›" if chosen in (None, "other") else chosen


def sentences() -> Iterator[str]:
    """Every message with arguments once for each of its choices, in every language."""
    for _, entry in entries(LANGUAGES[0]):
        parts = {"": entry.value} | {f".{each.id.name}": each.value for each in entry.attributes}
        for attribute, part in parts.items():
            if part is None:
                continue
            named, choices = Arguments(), Choices()
            named.visit(part)
            choices.visit(part)
            if not named.names:
                continue
            cases: list[tuple[str, str] | None] = [None]
            cases += [(name, key) for name, keys in choices.values.items() for key in keys]
            rendered = set[str]()
            for case in cases:
                values = {
                    name: sample(
                        name,
                        choices.values.get(name, []),
                        case[1] if case and case[0] == name else None,
                    )
                    for name in sorted(named.names)
                }
                id_ = entry.id.name + attribute
                both = texts(message(id_, **values))
                lines = "\n".join(f"  {language}: {text}" for language, text in both.items())
                if lines not in rendered:
                    yield f"{id_}{f' {case[0]}={case[1]}' if case else ''}\n{lines}"
                rendered.add(lines)


def test_each_message_says_with_its_arguments_what_is_kept():
    now = "\n".join(sentences()) + "\n"
    if os.environ.get("SENTENCES") == "renew":
        SENTENCES.write_text(now, encoding="utf-8")
    kept = SENTENCES.read_text(encoding="utf-8")
    assert now.splitlines() == kept.splitlines(), "see the first lines of this module"


def shape(entry: ast.Message) -> dict[str, set[str]]:
    parts = {"": entry.value} | {each.id.name: each.value for each in entry.attributes}
    found = {}
    for name, part in parts.items():
        visitor = Arguments()
        if part is not None:
            visitor.visit(part)
            found[name] = visitor.names
    return found


def test_every_language_has_the_same_messages_in_the_same_files_with_the_same_arguments():
    by_language = {
        language: {(file, entry.id.name): shape(entry) for file, entry in entries(language)}
        for language in LANGUAGES
    }
    first = by_language[LANGUAGES[0]]
    for language in LANGUAGES[1:]:
        assert by_language[language] == first


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_catalogue_is_understood_and_each_message_is_found_where_it_stands(language):
    """Every message, in every file, and none holds what is no message."""
    for path in (WORDS / language).glob("*.ftl"):
        body = parse(path.read_text(encoding="utf-8")).body
        assert not [entry for entry in body if isinstance(entry, ast.Junk)], path
    for file, entry in entries(language):
        assert _file_of(language)[entry.id.name] == file
        assert _catalogue_file(language, file).message(entry.id.name).id.name == entry.id.name


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_message_refers_only_to_messages_of_its_own_file(language):
    stood = list(entries(language))
    here = {(file, entry.id.name) for file, entry in stood}
    for file, entry in stood:
        visitor = References()
        visitor.visit(entry)
        assert {(file, name) for name in visitor.names} <= here, entry.id.name


def test_saying_a_message_parses_it_alone_of_its_own_catalogue_file():
    _catalogue_file.cache_clear()
    _rendered.cache_clear()
    say(message("clause-sequence", first="a", rest="b"), "en")
    assert _catalogue_file.cache_info().currsize == 1
    file = _file_of("en")["clause-sequence"]
    left = _catalogue_file("en", file).unparsed
    assert "clause-sequence" not in left
    assert len(left) > 5


def test_languages_are_the_folders():
    assert LANGUAGES == ("en", "zh")


def test_a_list_is_said_with_the_separator_of_its_language():
    listed = Message("list-separator")
    assert texts(listed) == {"en": ", ", "zh": "、"}


def test_a_text_of_any_length_fits_into_a_sentence():
    long = "x" * 9000
    assert say(message("clause-sequence", first=long, rest="y"), "en") == f"{long}; y"


def test_text_is_the_same_in_every_language():
    assert texts("gyro_x") == {"en": "gyro_x", "zh": "gyro_x"}


def test_a_statement_that_is_published_already_is_said_as_it_stands():
    title = Statement(en="a tilted base", zh="基座倾斜")
    assert texts(title) == {"en": "a tilted base", "zh": "基座倾斜"}
    assert statement(title) == title


def test_a_message_that_no_catalogue_has_is_an_error():
    assert not known("no-such-message")
    with pytest.raises(KeyError, match="no-such-message"):
        say(message("no-such-message"), "en")


def test_the_chinese_name_of_p_is_that_of_the_specification():
    """3.4 of JJF 2003: 加速度计角速度灵敏系数."""
    written = "".join(path.read_text(encoding="utf-8") for path in (WORDS / "zh").glob("*.ftl"))
    assert "加速度计角速度灵敏系数" in written
    assert "角速率敏感系数" not in written
    assert "角速度敏感系数" not in written


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("file", ["certificate", "conformity", "validation", "run_validity"])
def test_what_a_certificate_prints_names_no_command_and_no_file_of_the_program(language, file):
    written = (WORDS / language / f"{file}.ftl").read_text(encoding="utf-8")
    assert not [line for line in written.splitlines() if "`" in line or ".toml" in line]
    assert "mimucal" not in written


@pytest.mark.parametrize("language", LANGUAGES)
def test_messages_without_placeables_read_as_the_parser_has_them(language):
    plain = 0
    for name, entry in entries(language):
        catalogue = _catalogue_file(language, name)
        read = catalogue.plain(entry.id.name)
        if read is None:
            continue
        parsed = catalogue.message(entry.id.name)
        patterns = {"": parsed.value} | parsed.attributes
        assert read == {
            key: catalogue.bundle.format_pattern(pattern, {})[0]
            for key, pattern in patterns.items()
        }
        plain += 1
    assert plain > 300
