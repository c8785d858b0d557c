"""The record of a page, and the view (language, theme, visitor) for which it is laid out."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal
from urllib.parse import parse_qsl

from dash import Dash
from dash.development.base_component import Component
from flask import g, request

from flows.pages.numbers import Numbers
from schemas.access import Visitor
from schemas.base import Frozen
from storage.home import Home
from tasks.words import LANGUAGES, MAIN, Argument, Sayable, message, say

LANGUAGE, THEME = "mimucal_language", "mimucal_theme"
Theme = Literal["light", "dark"]


def parameters(search: str) -> dict[str, str]:
    """The fields of a query string, as `?id=r1` is one."""
    return dict(parse_qsl(search.removeprefix("?")))


@dataclass(frozen=True)
class View:
    """How somebody looks at the pages."""

    language: str = MAIN
    theme: Theme = "light"
    visitor: Visitor = field(default_factory=Visitor)

    def say(self, sayable: Sayable) -> str:
        """A message in the language of the view."""
        return say(sayable, self.language)

    def text(self, id_: str, /, **arguments: Argument) -> str:
        """A message of the catalogues, by its identifier."""
        return self.say(message(id_, **arguments))

    @property
    def figure_template(self) -> str:
        """The plotly template of the theme, as dash-mantine-components names it."""
        return f"mantine_{self.theme}"


@dataclass(frozen=True)
class Page:
    """A page at /NAME, its JSON at /api/v1/NAME and its words in pages.ftl at pages-NAME.

    question: the model of the query string, with a default for each field that may be left out.
    answer: the model that `data` gives, which is the JSON; `data` raises Unusable for what cannot
    be answered. layout: shows the answer to a question in a view. in_navigation: whether the
    header leads to it. has_grid: whether its lists are grids. refresh_s: after how long it is asked
    for again, for a page that is live. callbacks: registers what the page does by itself. numbers:
    its tables and charts as rows, at /api/v1/NAME/PART.csv.
    """

    name: str
    question: type[Frozen]
    answer: type[Frozen]
    data: Callable[[Any, Home], Frozen]
    layout: Callable[[Any, View, Any], Component]
    in_navigation: bool = True
    has_grid: bool = False
    refresh_s: float | None = None
    callbacks: Callable[[Dash, Home], None] | None = None
    numbers: Numbers = field(default_factory=dict)

    def title(self, view: View) -> str:
        """What the navigation and the heading call it."""
        return view.text(f"pages-{self.name}")

    def about(self, view: View) -> str:
        """One sentence of what it shows."""
        return view.text(f"pages-{self.name}.about")


def view_of_request() -> View:
    """The view that the request asks for: its cookies, else the browser's language, and light."""
    chosen = request.cookies.get(LANGUAGE)
    accepted = request.accept_languages.best_match(LANGUAGES, default=MAIN)
    theme: Theme = "dark" if request.cookies.get(THEME) == "dark" else "light"
    language = chosen if chosen in LANGUAGES else accepted
    return View(language=language, theme=theme, visitor=g.get("visitor") or Visitor())
