"""A language made of English, each text between ⟦ and ⟧: what is not so is of no catalogue."""

import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from fluent.syntax import FluentSerializer, ast, parse

from tasks.rendering import _environment
from tasks.words import LANGUAGES, MAIN, translation
from tasks.words.numbers import typeset

NAME = "xx"  # a code that no language has
BEGIN, END = "⟦", "⟧"
WRAPPED = re.compile(f"{BEGIN}[^{BEGIN}{END}]*{END}")
WORD = r"(?<!\w)[A-Za-z’']{2,}(?!\w)"
PHRASE = re.compile(rf"{WORD}(?:[ \u00a0]{WORD})+")
BY_WORD = ("typography-",)  # what a layout chooses by, and marks inside of sentences
CACHES = (
    translation._file_of, translation._bundle, translation._catalogue_file,
    translation._rendered, typeset,
    _environment,
)  # fmt: skip


@contextmanager
def spoken(folder: Path, name: str = NAME) -> Iterator[str]:
    """Gives the product a pseudo-language of this name, as a folder beside the others."""
    words = Path(str(translation.FOLDER))
    for each in LANGUAGES:
        if each != name:
            (folder / each).symlink_to(words / each)
    (folder / name).mkdir()
    for source in (words / MAIN).glob("*.ftl"):
        wrapped = _wrapped(source.read_text(encoding="utf-8"))
        (folder / name / source.name).write_text(wrapped, encoding="utf-8")
    languages = tuple(dict.fromkeys((*LANGUAGES, name)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(translation, "FOLDER", folder)
        _everywhere(LANGUAGES, languages)
        try:
            yield name
        finally:
            _everywhere(languages, LANGUAGES)
            _forget()


def _everywhere(before: tuple[str, ...], after: tuple[str, ...]) -> None:
    for module in list(sys.modules.values()):
        if getattr(module, "LANGUAGES", None) == before and module.__name__ != __name__:
            module.LANGUAGES = after
    _forget()


def _forget() -> None:
    for each in CACHES:
        each.cache_clear()


def _wrapped(catalogue: str) -> str:
    resource = parse(catalogue)
    for entry in resource.body:
        if isinstance(entry, ast.Message) and not entry.id.name.startswith(BY_WORD):
            for pattern in (entry.value, *(each.value for each in entry.attributes)):
                if pattern is not None:
                    pattern.elements[:0] = [ast.TextElement(BEGIN)]
                    pattern.elements.append(ast.TextElement(END))
    return FluentSerializer().serialize(resource)


def bare(text: str) -> str:
    """What of a text stands outside of the marks."""
    while (outer := WRAPPED.sub(" ", text)) != text:
        text = outer
    return text


def phrases(texts_: Iterable[str], words: int = 2) -> set[str]:
    """What stands outside of the marks and has so many words one after the other."""
    outside = (found for text in texts_ for found in PHRASE.findall(bare(text)))
    return {found for found in outside if len(found.split()) >= words}
