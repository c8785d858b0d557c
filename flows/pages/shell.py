"""The frame of every page: navigation, language and theme switches, and the page itself."""

import logging
from typing import Any

import dash_mantine_components as dmc
from dash import ClientsideFunction, Dash, Input, Output, dcc, html, set_props
from dash.development.base_component import Component
from flask_wtf.csrf import generate_csrf
from pydantic import ValidationError

from flows.pages import parts
from flows.pages.answers import PAGES
from flows.pages.login import fault
from flows.pages.parts import note, notice, parameters, said, say, view, zone
from schemas.base import Unusable, first_fault
from storage.catalogue.database import Busy
from storage.home import Home
from tasks.words import LANGUAGES, message
from tasks.words import say as translated

RETRY_S = 5.0  # after which a page that the database did not answer is asked for again
NEVER = 86_400_000  # ms
PageAndInterval = tuple[Component, int, bool]


def frame() -> Component:
    """The shell without a page, in the language and theme of the request."""
    return dmc.MantineProvider(
        dmc.AppShell(
            [
                dcc.Location(id="address", refresh="callback-nav"),
                dcc.Interval(id="again", interval=NEVER, disabled=True),
                dmc.AppShellHeader(_header(), px="md"),
                dmc.AppShellMain([dmc.Box(id="fault"), dmc.Box(id="page", className="figures")]),
            ],
            header={"height": {"base": 108, "md": 60}},  # on a tablet in two rows
            padding="md",
        ),
        forceColorScheme=view().theme,
    )


def _header() -> Component:
    links = [
        dmc.NavLink(
            label=page.title(), href=f"/{page.name}", active="partial", className="header-link"
        )
        for page in PAGES
        if page.in_navigation
    ]
    languages = [
        {"value": name, "label": translated(message("language-name"), name)} for name in LANGUAGES
    ]
    themes = [
        {"value": "light", "label": said("pages-light")},
        {"value": "dark", "label": said("pages-dark")},
    ]
    switches = [
        dmc.SegmentedControl(id="language", data=languages, value=view().language, size="xs"),
        dmc.SegmentedControl(id="theme", data=themes, value=view().theme, size="xs"),
        *_person(),
    ]
    return dmc.Group(
        [dmc.Group(links, gap=2, wrap="nowrap"), dmc.Group(switches, gap="xs", wrap="nowrap")],
        justify="space-between",
        gap=0,
        h="100%",
    )


def _person() -> list[Component]:
    """Who is logged in, and the way out; nobody where the home has no users."""
    if not view().visitor.name:
        return []
    role = said(f"pages-role.{view().visitor.role}")
    leave = [
        dcc.Input(type="hidden", name="csrf_token", value=generate_csrf()),
        html.Button(said("pages-login.leave"), type="submit", className="leave"),
    ]
    return [
        dmc.Text(f"{view().visitor.name} ({role})", size="xs", truncate="end", maw=140),
        html.Form(leave, action="/logout", method="POST"),
    ]


def say_fault(error: Exception) -> None:
    """What a page's own callback could not do, above the page; without a database it asks again."""
    if isinstance(error, Busy):
        set_props("again", {"disabled": False, "interval": int(RETRY_S * 1000)})
    words = "pages-not-answered" if isinstance(error, Unusable) else "pages-failed"
    if not isinstance(error, Unusable):
        logging.getLogger("mimucal.pages").error("a callback failed", exc_info=error)
    fault = error if isinstance(error, Unusable) else type(error).__name__
    set_props("fault", {"children": notice(words, "red", fault)})


def add_callbacks(app: Dash, home: Home) -> None:
    """The page of an address, asked for again where it is live or could not be answered."""

    @app.callback(
        Output("page", "children"),
        Output("again", "interval"),
        Output("again", "disabled"),
        Output("fault", "children"),
        Input("address", "pathname"),
        Input("address", "search"),
        Input("again", "n_intervals"),
    )
    def show(path: str | None, search: str | None, _: Any) -> tuple[Any, ...]:
        unreachable = fault()
        if unreachable is not None:
            return *no_database(unreachable), None
        return *page_at(path or "/", search or "", home), None

    app.clientside_callback(
        ClientsideFunction("preferences", "keep"),
        Output("language", "id"),
        Input("language", "value"),
        Input("theme", "value"),
        prevent_initial_call=True,
    )
    parts.callbacks(app)
    parts.picture_callbacks(app)
    for page in PAGES:
        if page.callbacks is not None:
            page.callbacks(app, home)


def page_at(path: str, search: str, home: Home) -> PageAndInterval:
    """The page of an address, the ms after which it is asked for again, and whether it is not."""
    name = path.strip("/")
    page = next((page for page in PAGES if page.name == name), None)
    if page is None:
        return notice("pages-no-such-page", "yellow"), NEVER, True
    try:
        question = page.question.model_validate(parameters(search))
        shown = page.layout(page.data(question, home), question)
    except ValidationError as error:
        return notice("pages-not-answered", "yellow", first_fault(error)), NEVER, True
    except Busy as error:
        return no_database(error)
    except Unusable as error:
        return notice("pages-not-answered", "yellow", error), NEVER, True
    interval = NEVER if page.refresh_s is None else int(page.refresh_s * 1000)
    heading = dmc.Title(page.title(), order=2)
    about = f"{page.about()} · {say(zone())}"
    return (
        dmc.Stack([dmc.Box([heading, note(about)]), shown], gap="md"),
        interval,
        page.refresh_s is None,
    )


def no_database(fault: Exception | str) -> PageAndInterval:
    """What a page says while the database does not answer; then it asks again."""
    return notice("pages-no-database", "red", fault), int(RETRY_S * 1000), False
