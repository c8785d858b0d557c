"""Identifies the visitor: by session, by HTTP basic authentication, or by a trusted reverse proxy.

A home without users, served on this machine alone, is there to look at for everybody on it.
"""

import hashlib
import os
import secrets
from contextlib import suppress
from datetime import timedelta
from typing import Any

from flask import Flask, Response, g, jsonify, redirect, request, session
from flask_wtf.csrf import CSRFError, CSRFProtect, generate_csrf
from werkzeug.wrappers import Response as AnyResponse

from flows.pages.api import PREFIX
from flows.pages.json_answers import refusal
from flows.pages.passwords import Gate
from schemas.access import User, Visitor
from schemas.base import Unusable
from storage import settings
from storage.catalogue.connection import Busy
from storage.catalogue.users import users
from storage.home import Home
from storage.whole_files import writing_in_home

KEY = "pages.key"
SESSION = timedelta(hours=12)
OPEN = ("/login", "/assets/", "/_dash-component-suites/", "/_favicon.ico")
WATCHED = ("/health", "/metrics")  # by what watches the line; health.py says who may
SHELL = ("/_dash-layout", "/_dash-dependencies")
UPDATE, OF_THE_FRAME = "/_dash-update-component", "..page.children."
ASK_AGAIN: dict[str, Any] = {  # as Dash has it for what a callback sets beside its outputs
    "multi": True, "response": {}, "sideUpdate": {"again": {"disabled": False, "interval": 1000}},
}  # fmt: skip
CSRF_COOKIE = "_csrf_token"  # where Dash looks for what it sends back as X-CSRFToken


def fault() -> str | None:
    """Why it could not be found out: the database does not answer."""
    found: str | None = g.get("fault")
    return found


def guard(server: Flask, home: Home) -> Gate:
    """Lets nobody in without a name; sets up sessions and the tokens against forged requests."""
    gate, pages = Gate(), settings.pages(home)
    server.config.update(
        SECRET_KEY=_key(home),
        PERMANENT_SESSION_LIFETIME=SESSION,
        SESSION_COOKIE_NAME="mimucal_session",
        SESSION_COOKIE_HTTPONLY=True,
        SESSION_COOKIE_SAMESITE="Lax",
        SESSION_COOKIE_SECURE=pages.https,
        WTF_CSRF_CHECK_DEFAULT=False,  # `not_forged` does, but for a script with its password
        WTF_CSRF_TIME_LIMIT=None,  # as long as the session: a tablet stays on its page
        WTF_CSRF_SSL_STRICT=False,  # Talisman's referrer policy sends none
    )

    @server.before_request
    def let_in() -> AnyResponse | None:
        if request.path.startswith(OPEN) or request.path in WATCHED:
            return None
        try:
            g.visitor = _identified(users(home), gate, home)
        except Busy as error:
            return _without_database(str(error))
        return None if g.visitor else _turned_away()

    tokens = CSRFProtect(server)

    @server.before_request
    def not_forged() -> None:
        # A browser that knows a password sends it by itself, but no form of another site JSON.
        if not (g.get("by_password") and request.is_json):
            tokens.protect()

    server.register_error_handler(CSRFError, lambda error: refusal(400, str(error.description)))

    @server.after_request
    def with_token(response: Response) -> Response:
        if response.mimetype == "text/html":
            response.set_cookie(CSRF_COOKIE, generate_csrf(), samesite="Strict", secure=pages.https)
        return response

    return gate


def log_in(user: User) -> None:
    """Begin a session of a user; whatever an earlier one held is gone."""
    session.clear()
    session.permanent = True
    session.update(name=user.name, password=_mark(user))


def _identified(known: dict[str, User], gate: Gate, home: Home) -> Visitor | None:
    """By the proxy's header, the session, or name and password; else None."""
    proxy = settings.pages(home).proxy
    if proxy and request.remote_addr in proxy.addresses:
        user = known.get(request.headers.get(proxy.header, ""))
        return _visitor(user)
    if not known and proxy is None:
        return Visitor()
    user = known.get(session.get("name", ""))
    if user and session.get("password") == _mark(user):
        return _visitor(user)
    if not request.path.startswith(PREFIX):
        return None
    user = by_password(known, gate)
    g.by_password = user is not None
    return _visitor(user)


def by_password(known: dict[str, User], gate: Gate) -> User | None:
    """A script says its name and password with each request (HTTP basic authentication)."""
    given, address = request.authorization, request.remote_addr or ""
    if given is None or given.username is None or gate.is_shut(given.username, address):
        return None
    user = known.get(given.username)
    return user if gate.check(user, given.password or "", given.username, address) else None


def _visitor(user: User | None) -> Visitor | None:
    return Visitor(name=user.name, role=user.role) if user else None


def _mark(user: User) -> str:
    """Ends sessions when a password changes, and says nothing of it."""
    return hashlib.sha256(user.password.encode()).hexdigest()[:16]


def _turned_away() -> AnyResponse:
    if request.path.startswith(PREFIX):
        refused = refusal(401, "say who you are: HTTP basic authentication, or log in at /login")
        refused.headers["WWW-Authenticate"] = 'Basic realm="mimucal", charset="UTF-8"'
        return refused
    if request.method == "GET" and not request.path.startswith("/_dash"):
        return redirect(f"/login?next={request.path}")
    return refusal(401, "the session has ended; log in again")


def _without_database(sentence: str) -> AnyResponse | None:
    """The frame of the pages is there without it, to say so and to ask again; nothing else is.

    Whatever else a page asks for by itself has the frame ask for the whole page again.
    """
    g.fault = sentence
    if request.path == UPDATE:
        asked = (request.get_json(silent=True) or {}).get("output", "")
        return None if str(asked).startswith(OF_THE_FRAME) else jsonify(ASK_AGAIN)
    is_page = request.method == "GET" and "text/html" in request.headers.get("Accept", "")
    return None if is_page or request.path in SHELL else refusal(503, sentence)


def _key(home: Home) -> str:
    """What signs the sessions: a file of the home; with no home yet, for this process alone."""
    path = home.path / KEY
    if not home.path.is_dir():
        return secrets.token_hex(32)
    with writing_in_home(path), suppress(FileExistsError):
        file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        os.write(file, secrets.token_hex(32).encode())
        os.close(file)
    try:
        return path.read_text(encoding="ascii")
    except OSError as error:
        raise Unusable(
            f"{path} cannot be read ({error.strerror}); grant access to it, or remove it and all "
            "sessions end."
        ) from error
