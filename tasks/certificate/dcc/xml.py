"""Elements of the DCC and of D-SI, and texts in both languages."""

import base64
from typing import Any

from lxml import etree
from lxml.builder import ElementMaker

from schemas.text import CONTRACTED, Statement
from tasks.certificate.fields import literal
from tasks.words import LANGUAGES, Sayable, say
from tasks.words.typography import typeset

DCC, SI = "https://ptb.de/dcc", "https://ptb.de/si"
NAMES = {"dcc": DCC, "si": SI}

Element = Any  # lxml's element, which has no public type

dcc = ElementMaker(namespace=DCC, nsmap=NAMES)
si = ElementMaker(namespace=SI, nsmap=NAMES)


def languages() -> tuple[str, ...]:
    """Every language, that of the specifications first."""
    return tuple(sorted(LANGUAGES, key=lambda language: language != CONTRACTED[-1]))


def contents(sayable: Sayable) -> list[Element]:
    """A text in every language, set as the printed certificate sets it."""
    return [dcc.content(_set(sayable, language) or "—", lang=language) for language in languages()]


def named(sayable: Sayable, tag: str = "name") -> Element:
    """A text by its tag: the name of something, unless another is given."""
    return dcc(tag, *contents(sayable))


def described(*sayables: Sayable, tag: str = "description") -> Element:
    """Sentences by their tag, each in both languages: one after the other in each language."""
    texts = [[_set(each, language) for each in sayables] for language in languages()]
    joined = ["\n".join(filter(None, lines)) or "—" for lines in texts]
    parts = [
        dcc.content(text, lang=language) for text, language in zip(joined, languages(), strict=True)
    ]
    return dcc(tag, *parts)


def plain(tag: str, text: str) -> Element:
    """A text that is the same in every language; a dash if it is empty."""
    return dcc(tag, literal(text) or "—")


def file(name: str, mime_type: str, content: bytes, tag: str = "file") -> Element:
    """A file within the document."""
    return dcc(
        tag,
        dcc.fileName(name),
        dcc.mimeType(mime_type),
        dcc.dataBase64(base64.b64encode(content).decode()),
    )


def canonical(root: Element) -> bytes:
    """The one way to write a document: every other byte would be another document."""
    return etree.tostring(root, method="c14n")


def _set(sayable: Sayable, language: str) -> str:
    if isinstance(sayable, str | Statement):
        return literal(say(sayable, language))
    return literal(typeset(say(sayable, language), language))
