"""Language and theme: two cookies that the switches in the header set."""

from flask import request

from flows.pages.page import Theme, View
from tasks.words import LANGUAGES

LANGUAGE, THEME = "mimucal_language", "mimucal_theme"


def view_of_request() -> View:
    """The view that the request asks for: its cookies, else the browser's language, and light."""
    chosen = request.cookies.get(LANGUAGE)
    accepted = request.accept_languages.best_match(LANGUAGES, default="en")
    theme: Theme = "dark" if request.cookies.get(THEME) == "dark" else "light"
    return View(language=chosen if chosen in LANGUAGES else accepted, theme=theme)
