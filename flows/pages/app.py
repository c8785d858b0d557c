"""The Dash application: shell, pages and JSON endpoints, with the security headers."""

import re
from importlib.resources import files

from dash import Dash
from flask import Blueprint, redirect, render_template, request
from flask_talisman import Talisman
from flask_wtf.csrf import generate_csrf
from werkzeug.wrappers import Response

from flows.pages import api, health, shell
from flows.pages.access import guard, log_in, log_out, passed
from flows.pages.compressed import compress
from flows.pages.files import files as certificate_files
from flows.pages.page import view_of_request
from flows.pages.passwords import Gate
from flows.pages.register import FIRST, PAGES
from schemas.base import Unusable
from storage import settings
from storage.catalogue.users import users
from storage.home import Home
from tasks.words import Message, message

Page = str | Response | tuple[str, int]
WORDS = {name: message(f"pages-login.{name}") for name in ("name", "password", "enter")}
UNUSED = "/dash_table/"  # tables that no page has
GRID = re.compile(r'<script src="([^"]*/dash_ag_grid/[^"]*)"></script>\n?')
CELLS = '<script async src="/_dash-component-suites/dash_ag_grid/async-community.js"></script>'


class Application(Dash):
    """Dash, with the language and theme of the request in the first document already."""

    def interpolate_index(
        self,
        metas: str = "",
        title: str = "",
        css: str = "",
        config: str = "",
        scripts: str = "",
        app_entry: str = "",
        favicon: str = "",
        renderer: str = "",
    ) -> str:
        """The first document, before any script has run."""
        view = view_of_request()
        tags = scripts.splitlines()
        scripts = "\n".join(tag for tag in tags if UNUSED not in tag)
        early, late = CELLS, ""
        grid = GRID.search(scripts)
        if grid and not _shows_grid():
            early, late = "", f' data-grid="{grid[1]}"'
            scripts = GRID.sub("", scripts)
        return f"""<!DOCTYPE html>
<html lang="{view.language}"
 data-mantine-color-scheme="{view.theme}" data-ag-theme-mode="{view.theme}"{late}>
<head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
{metas}<title>{title}</title>{favicon}{css}{early}</head>
<body>{app_entry}<footer>{config}{scripts}{renderer}</footer></body>
</html>"""


def _shows_grid() -> bool:
    """Whether the page asked for begins with a grid, whose script Dash loads after all others."""
    name = request.path.strip("/")
    return any(page.name == name for page in PAGES if page.has_grid) and "id" not in request.args


def make_app(home: Home) -> Application:
    """The pages of a home as an application; nothing is opened before somebody asks."""
    app = Application(
        "mimucal",
        assets_folder=str(files("flows.pages") / "assets"),
        serve_locally=True,
        suppress_callback_exceptions=True,  # a page's parts are there when it is
        update_title="",
        on_error=shell.say_fault,
        title="mimucal",
    )
    app.enable_dev_tools(debug=False, dev_tools_disable_version_check=True)
    app.layout = shell.frame
    shell.add_callbacks(app, home)
    app.server.register_blueprint(api.endpoints(home))
    app.server.register_blueprint(certificate_files(home))
    app.server.before_request(_to_first_page)
    _keep_at_home(app, is_https=settings.pages(home).https)
    gate = guard(app.server, home)
    app.server.before_request(api.unknown_address)
    app.server.register_blueprint(login(home, gate))
    app.server.register_blueprint(health.endpoints(home, gate))
    compress(app.server)
    return app


def _to_first_page() -> Response | None:
    return redirect(f"/{FIRST.name}") if request.path == "/" else None


def _keep_at_home(app: Application, is_https: bool) -> None:
    """Headers by which a browser asks no other host, and no other page frames this one."""
    own = "'self'"
    policy = {
        "default-src": own,
        "script-src": [own, *app.csp_hashes()],
        "style-src": [own, "'unsafe-inline'"],  # the components write styles of their own
        "img-src": [own, "data:", "blob:"],
        "font-src": [own, "data:"],
        "frame-ancestors": "'none'",
        "form-action": own,
        "base-uri": own,
        "object-src": "'none'",
    }
    Talisman(
        app.server,
        force_https=False,  # on loopback, or behind a proxy that ends TLS
        strict_transport_security=is_https,
        session_cookie_secure=is_https,
        session_cookie_samesite="Lax",
        frame_options="DENY",
        referrer_policy="same-origin",
        content_security_policy=policy,
    )


def login(home: Home, gate: Gate) -> Blueprint:
    """The form, and what becomes of it."""
    made = Blueprint("login", __name__, template_folder="templates")

    @made.get("/login")
    def form() -> Page:
        return _form(None, request.args.get("next", ""))

    @made.post("/login")
    def enter() -> Page:
        name, password = request.form.get("name", ""), request.form.get("password", "")
        address, wanted = request.remote_addr or "", request.form.get("next", "")
        if gate.is_locked(name, address):
            return _form(message("pages-login.shut"), wanted), 429
        try:
            user = users(home).get(name)
            if not passed(user, password, name, gate, home) or user is None:
                return _form(message("pages-login.wrong"), wanted), 403
            log_in(user, home)
        except Unusable:
            return _form(message("pages-no-database"), wanted), 503
        return redirect(_own(wanted))

    @made.post("/logout")
    def leave() -> Page:
        try:
            log_out(home)
        except Unusable:
            return _form(message("pages-no-database"), ""), 503
        return redirect("/login")

    return made


def _own(wanted: str) -> str:
    """The page that somebody wanted, if it is one of ours; else the first."""
    return wanted if wanted in {f"/{page.name}" for page in PAGES} else "/"


def _form(fault: Message | None, wanted: str) -> str:
    view = view_of_request()
    return render_template(
        "login.html", language=view.language, theme=view.theme, next=wanted,
        fault=fault and view.say(fault), token=generate_csrf(),
        words={name: view.say(each) for name, each in WORDS.items()},
    )  # fmt: skip
