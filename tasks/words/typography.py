"""Typography of sentences: dashes, minus signs and equation numbers by language.

What the numerics write in one way for all languages (“eq. (3)-(5)”, “Table 1”, `-9.8`) is set by
the messages `typography-…` of each catalogue.
"""

import re
from functools import lru_cache, partial
from typing import Any

from schemas.text import Statement
from tasks.words.message import Argument, message
from tasks.words.rounding import MINUS
from tasks.words.translation import LANGUAGES, say

NO_BREAK = "\u00a0"
FULL_STOPS = ".\u3002"  # Latin and Chinese
_NUMBER = r"\((?:[A-Z]\.)?\d+\)"
_SENTENCE = (
    (r"\bJJF (?P<number>\d+)-(?P<year>\d{4})\b", "specification"),
    (rf"eq\. (?P<first>{_NUMBER})–(?P<last>{_NUMBER})", "equations.range"),
    (rf"eq\. (?P<numbers>{_NUMBER}(?:, {_NUMBER})*)", "equations"),
    (rf"(?<=\d)~(?=[\d{MINUS}])", "range"),
)
_CLAUSE = (
    (r"list under (?P<equation>eq\. \(\d+\))", "list-under"),
    (r"Appendix (?P<letter>[A-Z]), (?P<entry>\d+)", "appendix.entry"),
    (r"Appendix (?P<letter>[A-Z])", "appendix"),
    (r"Table (?P<number>\d)", "table"),
    (r"(?<=\d) to (?=\d)", "from-to"),
    (r"(?<=\)) and (?=eq\.)", "and.equations"),
    (r", joint method with gravity alone", "joint-method.gravity"),
    (r", joint method", "joint-method"),
    (r", (?=eq\.)", "comma.equation"),
    *_SENTENCE,
    (r" and ", "and"),
    (r", ", "comma"),
)


@lru_cache(maxsize=4096)  # certificates say the same of many units
def typeset(text: str, language: str) -> str:
    """A sentence with real minus signs, ° for deg, “< 0.1 %” on one line, and what its language
    has for the rest.
    """
    text = re.sub(r"(?<![\w.)\]-])-(?=\d|[xyz]\b)", MINUS, text)
    text = re.sub(rf"(eq\. {_NUMBER})-(?={_NUMBER})", r"\1–", text)
    text = re.sub(r"(?<=[<>]) (?=\d)|(?<=\d) (?=%)", NO_BREAK, text)
    return _replaced(re.sub(r"\bdeg/s\b", "°/s", text), _SENTENCE, language)


def clause(text: str, specification: str = "") -> Statement:
    """A clause in every language, without the name of the specification that is meant anyway."""
    short = text.removeprefix(specification).strip(" ,")
    short = re.sub(rf"(eq\. {_NUMBER})-(?={_NUMBER})", r"\1–", short)
    made: dict[str, Any] = {language: _clause(short, language) for language in LANGUAGES}
    return Statement(**made)


def _clause(text: str, language: str) -> str:
    return typeset(_replaced(text, _CLAUSE, language), language)


def _replaced(text: str, rules: tuple[tuple[str, str], ...], language: str) -> str:
    for pattern, name in rules:
        text = re.sub(pattern, partial(_filled, name, language), text)
    return text


def _filled(name: str, language: str, match: re.Match[str]) -> str:
    arguments: dict[str, Argument] = dict(match.groupdict())
    if name == "equations":
        numbers = match["numbers"].split(", ")
        arguments["numbers"] = tuple(message("typography-equation", number=n) for n in numbers)
    return say(message(f"typography-{name}", **arguments), language)
