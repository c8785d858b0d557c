"""The catalogues: every sentence in every language, and messages said in one of them."""

from collections.abc import Iterable, Mapping
from functools import cache, lru_cache
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any

from schemas.text import Remark, Statement
from tasks.words.message import Argument, Message, Sayable

SUFFIX = ".ftl"
LONG = 1000  # characters; the formatter takes no argument of more than 2500
SEPARATOR = "list-separator"  # between the entries of a list, in each catalogue


def _folders() -> Iterable[Traversable]:
    return (each for each in files("tasks.words").iterdir() if _sources(each))


def _sources(folder: Traversable) -> list[Traversable]:
    """The catalogue files of one language, by name; none where it is no language's folder."""
    if not folder.is_dir():
        return []
    found = (each for each in folder.iterdir() if each.name.endswith(SUFFIX))
    return sorted(found, key=lambda each: each.name)


LANGUAGES: tuple[str, ...] = tuple(sorted(folder.name for folder in _folders()))


@cache
def _bundle(language: str) -> tuple[Any, frozenset[str]]:
    """All catalogue files of one language, and their identifiers.

    Raises ValueError where an identifier stands twice.
    """
    # Late: a command that says nothing needs no parser.
    from fluent.runtime import FluentBundle, FluentResource
    from fluent.syntax import ast

    bundle = FluentBundle([language], use_isolating=False)
    files_of: dict[str, str] = {}
    for source in _sources(files("tasks.words") / language):
        resource = FluentResource(source.read_text(encoding="utf-8"))
        where = f"{language}/{source.name}"
        for entry in resource.body:
            if isinstance(entry, ast.Junk):
                raise ValueError(f"{where}: not understood: {str(entry.content).strip()[:80]!r}")
            if isinstance(entry, ast.Message | ast.Term):
                if entry.id.name in files_of:
                    raise ValueError(
                        f"{where}: {entry.id.name} stands in {files_of[entry.id.name]} too"
                    )
                files_of[entry.id.name] = where
        bundle.add_resource(resource)
    return bundle, frozenset(files_of)


def known(id_: str) -> bool:
    """Whether the catalogues have a message, or an attribute of one, of this identifier."""
    return all(_pattern(language, id_) is not None for language in LANGUAGES)


def identifiers(prefix: str) -> tuple[str, ...]:
    """The messages whose identifiers begin so, in the order of the alphabet."""
    return tuple(sorted(id_ for id_ in _bundle(LANGUAGES[0])[1] if id_.startswith(prefix)))


@lru_cache(maxsize=4096)  # a study calibrates thousands of units, which say the same
def say(sayable: Sayable, language: str) -> str:
    """A message or statement in one language; mere text is the same in all.

    Raises KeyError for a message that the catalogue lacks, or that asks for an argument it has
    not got.
    """
    if isinstance(sayable, str):
        return sayable
    if isinstance(sayable, Statement):
        return str(getattr(sayable, language, sayable.en))
    pattern = _pattern(language, sayable.id)
    if pattern is None:
        raise KeyError(f"the {language} catalogue has no message {sayable.id}")
    arguments = {name: _argument(value, language) for name, value in sayable.arguments}
    long = {n: text for n, text in arguments.items() if isinstance(text, str) and len(text) > LONG}
    places = {name: f"\ue000{name}\ue001" for name in long}  # private use: in no text
    text, errors = _bundle(language)[0].format_pattern(pattern, arguments | places)
    if errors:
        raise KeyError(f"{sayable.id} ({language}): {errors[0]}")
    for name, place in places.items():
        text = text.replace(place, long[name])
    return str(text)


def texts(sayable: Sayable) -> Mapping[str, str]:
    """A message in every language, by language: the fields of a `Remark`, for one."""
    return {language: say(sayable, language) for language in LANGUAGES}


def statement(sayable: Sayable) -> Statement:
    """A message as it is published, in every language."""
    if isinstance(sayable, Statement):
        return sayable
    return Statement(en=say(sayable, "en"), zh=say(sayable, "zh"))


def remark(
    code: str, sayable: Sayable, segments: tuple[str, ...] = (), *, blocks_pass: bool = False
) -> Remark:
    """A message as a remark of a calibration."""
    en, zh = (say(sayable, language) for language in ("en", "zh"))
    return Remark(code=code, en=en, zh=zh, segments=segments, blocks_pass=blocks_pass)


def _argument(value: Argument, language: str) -> object:
    from fluent.runtime.types import fluent_number

    if isinstance(value, tuple):
        separator = say(Message(SEPARATOR), language)
        return separator.join(str(_argument(each, language)) for each in value)
    if isinstance(value, Message | Statement):
        return say(value, language)
    return fluent_number(value, useGrouping=False) if isinstance(value, int) else value


def _pattern(language: str, id_: str) -> Any:
    """The pattern of «message» or «message.attribute»; None where there is none."""
    name, _, attribute = id_.partition(".")
    bundle, _ = _bundle(language)
    if not bundle.has_message(name):
        return None
    found = bundle.get_message(name)
    return found.attributes.get(attribute) if attribute else found.value
