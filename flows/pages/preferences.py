"""Language and theme of a visitor, kept in cookies."""

from flask import g, request

from flows.pages.page import Theme, View
from schemas.access import Visitor
from tasks.words import LANGUAGES

LANGUAGE, THEME = "mimucal_language", "mimucal_theme"


def view_of_request() -> View:
    """The view that the request asks for: its cookies, else the browser's language, and light."""
    chosen = request.cookies.get(LANGUAGE)
    accepted = request.accept_languages.best_match(LANGUAGES, default="en")
    theme: Theme = "dark" if request.cookies.get(THEME) == "dark" else "light"
    language = chosen if chosen in LANGUAGES else accepted
    return View(language=language, theme=theme, visitor=g.get("visitor") or Visitor())
