"""The message catalogues, and messages rendered in one language."""

import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache, lru_cache, partial
from importlib.resources import files
from itertools import takewhile
from threading import Lock
from typing import Any

from schemas.base import Unusable
from schemas.text import (
    BOTH,
    CONTRACTED,
    Argument,
    Message,
    Remark,
    RunVerdict,
    Sayable,
    Statement,
    Wording,
)

COMMON = "common.ftl"  # every language has it
IDENTIFIER = re.compile(r"^([a-zA-Z][\w-]*) *=", re.MULTILINE)
PLAIN = re.compile(r"(?:[a-zA-Z][\w-]*|    \.(?P<attribute>[\w-]+)) *= *(?P<text>[^{}]*[^{}\s])")
WORD = re.compile(r"[a-zA-Z][\w-]*")
LONG = 2400  # characters; the formatter takes no argument of more than 2500
CLAUSE = re.compile(r"(?<=[:;]) ")
OF_TERMINALS = re.compile(r"`|--[a-z]|[A-Z]{3,}_[A-Z]|[a-z]+://")
PLACE = re.compile(r"(?<![\w.°/:])(?:/[\w.@ -]+)*/(?=[\w.-])")  # of a file, before its name
SEPARATOR = "list-separator"  # between the entries of a list, in each catalogue
FOLDER = files("tasks.words")
MAIN = CONTRACTED[0]  # of the terminal, the logs, and where nobody chooses
LANGUAGES: tuple[str, ...] = tuple(
    sorted(
        (each.name for each in FOLDER.iterdir() if (each / COMMON).is_file()),
        key=lambda name: (name != MAIN, name),
    )
)


@cache
def _file_of(language: str) -> Mapping[str, str]:
    """Where each message of a language stands: its identifier, and the name of its file.

    Raises ValueError where an identifier stands twice, Unusable for a language without catalogues.
    """
    if language not in LANGUAGES:
        raise Unusable(
            f"language {language!r} of an order, laboratory.toml or recall.toml has no catalogue: "
            f"give one of {', '.join(LANGUAGES)} (of certificates also {BOTH!r})."
        )
    found: dict[str, str] = {}
    catalogues = (each for each in (FOLDER / language).iterdir() if each.name.endswith(".ftl"))
    for source in catalogues:
        for id_ in IDENTIFIER.findall(source.read_text(encoding="utf-8")):
            if id_ in found:
                raise ValueError(
                    f"{language}/{source.name}: {id_} stands in {language}/{found[id_]} too"
                )
            found[id_] = source.name
    return found


@cache
def _bundle(language: str) -> Any:
    """The messages of a language that were parsed, of every file."""
    # Late: a command that says nothing needs no parser.
    from fluent.runtime import FluentBundle

    functions: dict[str, Any] = {
        "CAPITAL": partial(_initial, str.upper),
        "LOWER": partial(_initial, str.lower),
    }
    return FluentBundle([language], use_isolating=False, functions=functions)


def _initial(change: Callable[[str], str], text: str) -> str:
    """A text with another initial; a symbol stays as it is."""
    is_word = text[1:2].islower() or text.startswith("a ")
    return change(text[:1]) + text[1:] if is_word else text


class _File:
    """One catalogue file. A message is parsed when it is first asked for, with those of the file
    that it may refer to: parsing all of them takes longer than most commands.
    """

    def __init__(self, language: str, name: str) -> None:
        self._name = f"{language}/{name}"
        text = (FOLDER / language / name).read_text(encoding="utf-8")
        starts = [found.start() for found in IDENTIFIER.finditer(text)]
        parts = [text[start:end] for start, end in zip(starts, [*starts[1:], None], strict=True)]
        self.texts = dict(zip(IDENTIFIER.findall(text), parts, strict=True))
        self.unparsed = set(self.texts)
        self.bundle = _bundle(language)
        self._one_at_a_time = Lock()

    def plain(self, id_: str) -> Mapping[str, str] | None:
        """Text and attributes of a message of single lines without placeables, which most are and
        which need no parser; the text's own key is empty. None for any other.
        """
        lines = [line for line in self.texts[id_].split("\n") if line and line[0] != "#"]
        found = [PLAIN.fullmatch(line) for line in lines]
        if not all(found):
            return None
        return {each["attribute"] or "": each["text"] for each in found if each}

    def message(self, id_: str) -> Any:
        """The message, parsed. Raises ValueError where it is not understood."""
        with self._one_at_a_time:
            self._parse(id_)
        return self.bundle.get_message(id_)

    def _parse(self, id_: str) -> None:
        from fluent.runtime import FluentResource
        from fluent.syntax.ast import Junk

        if id_ not in self.unparsed:
            return
        self.unparsed.remove(id_)
        text = self.texts[id_]
        resource = FluentResource(text)
        for entry in resource.body:
            if isinstance(entry, Junk):
                content = str(entry.content).strip()
                raise ValueError(f"{self._name}: not understood: {content[:80]!r}")
        self.bundle.add_resource(resource)
        for word in WORD.findall(text):
            self._parse(word)


_catalogue_file = cache(_File)


def known(id_: str) -> bool:
    """Whether the catalogues have a message, or an attribute of one, of this identifier."""
    return all(_pattern(language, id_)[1] is not None for language in LANGUAGES)


def identifiers(prefix: str) -> tuple[str, ...]:
    """The messages whose identifiers begin so, in the order of the alphabet."""
    return tuple(sorted(id_ for id_ in _file_of(LANGUAGES[0]) if id_.startswith(prefix)))


def say(sayable: Sayable, language: str = MAIN) -> str:
    """A message or statement in one language; mere text is the same in all.

    A statement is rendered from its message; in the words that it was kept in where it has none, or
    one that the catalogues do not have any more. Raises KeyError for a message that the catalogue
    lacks, or that asks for an argument it has not got.
    """
    if isinstance(sayable, str):
        return sayable
    if isinstance(sayable, Statement):
        if sayable.message is not None:
            with suppress(KeyError):
                return say(sayable.message, language)
        return sayable.words.get(language) or sayable.words[MAIN]
    return _rendered(sayable, language)


@lru_cache(maxsize=4096)  # a study calibrates thousands of units, which say the same
def _rendered(sayable: Message, language: str) -> str:
    bundle, pattern = _pattern(language, sayable.id)
    if pattern is None:
        raise KeyError(f"the {language} catalogue has no message {sayable.id}")
    if isinstance(pattern, str):
        return pattern
    arguments = {name: _argument(value, language) for name, value in sayable.arguments}
    long = {n: text for n, text in arguments.items() if isinstance(text, str) and len(text) > LONG}
    places = {name: f"\ue000{name}\ue001" for name in long}  # private use: in no text
    text, errors = bundle.format_pattern(pattern, arguments | places)
    if errors:
        raise KeyError(f"{sayable.id} ({language}): {errors[0]}")
    for name, place in places.items():
        text = text.replace(place, long[name])
    return str(text)


def cause_of(fault: BaseException | str) -> Statement:
    """Why something failed, as pages and alerts show it.

    That is the cause that a fault carries, or one that led to it. Of a mere sentence, made for a
    terminal, English shows what stands before the first command, with files by their names alone;
    the other languages say that the log has it.
    """
    led: BaseException | None = fault if isinstance(fault, BaseException) else None
    while led is not None:
        if isinstance(cause := getattr(led, "cause", None), Message | Statement):
            return statement(cause)
        led = led.__cause__
    sentence = str(fault) or type(fault).__name__
    clauses_ = CLAUSE.split(PLACE.sub("", sentence))
    plain = takewhile(lambda clause: not OF_TERMINALS.search(clause), clauses_)
    shown = " ".join(plain).rstrip(":; ")
    if shown.count("(") > shown.count(")"):  # the rest of it was not for a page
        shown = shown.rpartition("(")[0].rstrip()
    other = texts(Message("station-cause.other"))
    words: dict[str, Any] = {**other, MAIN: shown or other[MAIN]}
    return Statement(**words)


def texts(sayable: Sayable) -> Mapping[str, str]:
    """A message in every language, by language: the fields of a `Remark`, for one."""
    return {language: say(sayable, language) for language in LANGUAGES}


def statement(sayable: Sayable | Wording) -> Statement:
    """A message rendered for publication, in every language."""
    return Statement(**worded(sayable))


def worded(sayable: Sayable | Wording) -> dict[str, Any]:
    """A message as the fields of a statement: in every language, and as it is."""
    if isinstance(sayable, Statement):
        return {**texts(sayable), **sayable.words, "message": sayable.message}
    if isinstance(sayable, Wording):
        return dict(sayable.words)
    return {**texts(sayable), "message": sayable if isinstance(sayable, Message) else None}


def remark(
    code: str,
    sayable: Sayable,
    segments: tuple[str, ...] = (),
    *,
    blocks_pass: bool = False,
    run: RunVerdict = "valid",
) -> Remark:
    """A message as a remark of a calibration."""
    return Remark(**worded(sayable), code=code, segments=segments, blocks_pass=blocks_pass, run=run)


def _argument(value: Argument, language: str) -> object:
    from fluent.runtime.types import fluent_number

    if isinstance(value, tuple):
        separator = say(Message(SEPARATOR), language)
        return separator.join(str(_argument(each, language)) for each in value)
    if isinstance(value, Message | Statement):
        return say(value, language)
    return fluent_number(value, useGrouping=False) if isinstance(value, int) else value


def _pattern(language: str, id_: str) -> tuple[Any, Any]:
    """The bundle and pattern of `message` or `message.attribute`, of one without placeables its
    text; None where there is none.
    """
    name, _, attribute = id_.partition(".")
    file = _file_of(language).get(name)
    if file is None:
        return None, None
    catalogue = _catalogue_file(language, file)
    plain = catalogue.plain(name)
    if plain is not None:
        return None, plain.get(attribute)
    found = catalogue.message(name)
    return catalogue.bundle, found.attributes.get(attribute) if attribute else found.value
