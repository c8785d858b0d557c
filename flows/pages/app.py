"""The Dash application: shell, pages and JSON endpoints, with the security headers."""

import gc
import gzip
import logging
import re
from functools import lru_cache
from importlib.resources import files
from ipaddress import ip_address
from typing import Any

from dash import Dash
from flask import Blueprint, Flask, redirect, render_template, request
from flask import Response as FlaskResponse
from flask_talisman import Talisman
from flask_wtf.csrf import generate_csrf
from waitress.server import create_server
from werkzeug.wrappers import Response

from flows.logs import set_up
from flows.pages import answers, health, shell
from flows.pages.answers import FIRST, PAGES
from flows.pages.answers import files as certificate_files
from flows.pages.login import LoginLimiter, guard, log_in, log_out, passed
from flows.pages.parts import say, view
from flows.terminal import stdout
from schemas.base import Unusable
from storage import settings
from storage.catalogue.users import users
from storage.home import Home
from tasks.words import Message, message

# Compresses answers with gzip for clients that accept it, such as tablets on a slow network.

KINDS = ("text/javascript", "application/javascript", "application/json")
LEAST = 2_000  # smallest answer worth compressing, bytes
SCRIPTS = 32  # compressed scripts kept in memory
QUICK = 1  # level, for what is compressed anew each time


def compress(server: Flask) -> None:
    """Compresses scripts, once each, and JSON."""

    @server.after_request
    def smaller(response: FlaskResponse) -> FlaskResponse:
        if response.mimetype not in KINDS or response.status_code != 200:
            return response
        response.vary.add("Accept-Encoding")
        is_file = response.is_streamed or response.direct_passthrough
        if is_file or "gzip" not in request.accept_encodings:
            return response
        content = response.get_data()
        if len(content) >= LEAST:
            is_json = response.mimetype == "application/json"
            response.set_data(gzip.compress(content, QUICK) if is_json else _script(content))
            response.content_encoding = "gzip"
        return response


@lru_cache(SCRIPTS)
def _script(content: bytes) -> bytes:
    return gzip.compress(content)


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
        tags = scripts.splitlines()
        scripts = "\n".join(tag for tag in tags if UNUSED not in tag)
        early, late = CELLS, ""
        grid = GRID.search(scripts)
        if grid and not _shows_grid():
            early, late = "", f' data-grid="{grid[1]}"'
            scripts = GRID.sub("", scripts)
        return f"""<!DOCTYPE html>
<html lang="{view().language}"
 data-mantine-color-scheme="{view().theme}" data-ag-theme-mode="{view().theme}"{late}>
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
    app.server.register_blueprint(answers.endpoints(home))
    app.server.register_blueprint(certificate_files(home))
    app.server.before_request(_to_first_page)
    _keep_at_home(app, is_https=settings.pages(home).https)
    gate = guard(app.server, home)
    app.server.before_request(answers.unknown_address)
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


def login(home: Home, gate: LoginLimiter) -> Blueprint:
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
    return render_template(
        "login.html", language=view().language, theme=view().theme, next=wanted,
        fault=fault and say(fault), token=generate_csrf(),
        words={name: say(each) for name, each in WORDS.items()},
    )  # fmt: skip


# `mimucal dashboard`: serves the pages until Ctrl-C.

HERE = ("127.0.0.1", "localhost", "[::1]")
THREADS = 8  # requests answered at the same time; further ones wait


def serve(home: Home, host: str, port: int) -> None:
    """Serve the pages of a home; raises Unusable for an address that cannot be listened on."""
    set_up(errors_at_least=True)
    server = listening(home, host, port)
    stdout(markup=False).print(
        f"http://{host}:{server.effective_port}/ (Ctrl-C ends it)", highlight=False
    )
    server.run()


def listening(home: Home, host: str, port: int) -> Any:
    """A server of the pages that listens already; `run` answers, `close` ends it."""
    _check_reach(home, host)
    app = make_app(home).server
    gc.freeze()  # what was imported lives to the end: no collection walks over it again
    pages = settings.pages(home)
    if _is_here(host) and pages.proxy is None and not pages.https:
        # A page of another host whose name leads here must not read what is open on this machine.
        app.config["TRUSTED_HOSTS"] = list(HERE)
    logging.getLogger("waitress.queue").setLevel(logging.ERROR)  # that somebody waits is no fault
    try:
        return create_server(
            app, host=host, port=port, threads=THREADS, ident="mimucal",
            clear_untrusted_proxy_headers=False,  # by them health.py sees who comes from elsewhere
        )  # fmt: skip
    except (OSError, ValueError) as error:
        raise Unusable(
            f"the pages cannot be served at {host} port {port} ({error}); choose others with "
            "--host and --port."
        ) from error


def _check_reach(home: Home, host: str) -> None:
    """Raises Unusable for pages that everybody on the network could look at without a name."""
    if not _is_here(host) and not users(home) and settings.pages(home).proxy is None:
        raise Unusable(
            f"--host {host} opens the pages to other computers, but nobody has a password yet; "
            "first run `mimucal user add NAME --role administrator`, or name a proxy in "
            f"{home.path / settings.PAGES}."
        )


def _is_here(host: str) -> bool:
    """Whether an address is reached from this machine alone."""
    try:
        return host == "localhost" or ip_address(host).is_loopback
    except ValueError:
        return False
