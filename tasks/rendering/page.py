"""HTML pages from templates: `templates/base.html` has the style, a folder by each user content."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tasks.words import LANGUAGES, Sayable, message, texts

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

BASE = Path(__file__).parent / "templates"


def page(template: Path, **values: Any) -> str:
    """The HTML of a template that extends base.html, which needs nothing from elsewhere.

    Templates have `say(id, …)` for a message of the catalogues, and the filter `text` for anything
    sayable; both are escaped.
    """
    return _environment(template.parent).get_template(template.name).render(**values) + "\n"


@cache
def _environment(folder: Path) -> "Environment":
    """Compiles each template of a folder once."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # late: only pages need them

    environment = Environment(
        loader=FileSystemLoader([folder, BASE]),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"text": _text}
    names = texts(message("language-name"))
    environment.globals |= {"say": _message, "languages": LANGUAGES, "language_name": names}
    return environment


def inline(svg: str) -> "Markup":
    """A chart embedded in a page unchanged."""
    from markupsafe import Markup

    return Markup(svg)


def inline_each(by_language: Mapping[str, str]) -> "Markup":
    """A chart in every language, of which the page shows one."""
    from markupsafe import Markup

    span = Markup('<span lang="{}">{}</span>')
    return Markup("").join(
        span.format(language, Markup(svg)) for language, svg in by_language.items()
    )


def _text(phrase: Sayable) -> "Markup":
    """In every language, of which the page shows one; once where all are the same."""
    from markupsafe import Markup

    if hasattr(phrase, "__html__"):
        return Markup(phrase)
    by_language = texts(phrase)
    if len(set(by_language.values())) == 1:
        return Markup("{}").format(by_language[LANGUAGES[0]])
    span = Markup('<span lang="{}">{}</span>')
    return Markup("").join(span.format(language, text) for language, text in by_language.items())


def _message(id_: str, **arguments: Any) -> "Markup":
    return _text(message(id_, **arguments))
