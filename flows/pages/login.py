"""Who may see and do what on the pages: users, sessions, proxies and passwords."""

import hashlib
import hmac
import secrets
from collections.abc import Iterator
from datetime import timedelta
from typing import Any
from urllib.parse import quote

from argon2 import PasswordHasher
from argon2.exceptions import Argon2Error, InvalidHashError
from flask import Flask, Response, g, jsonify, redirect, request, session
from flask_wtf.csrf import CSRFError, CSRFProtect, generate_csrf
from limits import RateLimitItem, parse
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter
from werkzeug.exceptions import HTTPException
from werkzeug.wrappers import Response as AnyResponse

from flows.access_log import LOGGER, UNKNOWN, plain, refused
from flows.pages.answers import PREFIX
from flows.pages.parts import refusal
from schemas.access import Proxy, User, Visitor
from schemas.base import Unusable
from storage import settings, whole_files
from storage.catalogue import users
from storage.catalogue.database import Busy
from storage.catalogue.users import users as registered_users
from storage.home import Home

# Passwords: hashed with Argon2id, checked with a limit on failed attempts.

HASHER = PasswordHasher()
LONGEST = 100  # characters of a user's name
# Failed attempts. One account from one address is locked soon; an account from any address, and an
# address of many people (a proxy, a laboratory behind one router), only after far more than
# ordinary typing errors.
PER_ACCOUNT_AND_ADDRESS = (parse("5/minute"), parse("30/hour"))
PER_ACCOUNT = (parse("20/minute"), parse("100/hour"))
PER_ADDRESS = (parse("60/minute"), parse("600/hour"))


def hashed(password: str) -> str:
    """The Argon2id hash of a password, with its salt and parameters."""
    return HASHER.hash(password)


DUMMY_HASH = hashed("")  # so that an unknown name takes as long as a known one


class LoginLimiter:
    """Checks a user's password, with a limit on failed attempts. Attempts are counted in the memory
    of the process that serves the pages. An account that does not exist is locked like any other.
    """

    def __init__(self) -> None:
        self._failed = MovingWindowRateLimiter(MemoryStorage())

    def is_locked(self, name: str, address: str) -> bool:
        """Whether so many tries failed that no further one is looked at."""
        return not all(self._failed.test(limit, *keys) for limit, keys in _limits(name, address))

    def check(self, user: User | None, password: str, name: str, address: str) -> bool:
        """Whether a password is the user's; a try that fails is counted."""
        try:
            right = (
                HASHER.verify(user.password if user else DUMMY_HASH, password) and user is not None
            )
        except (Argon2Error, InvalidHashError):
            right = False
        if not right:
            for limit, keys in _limits(name, address):
                self._failed.hit(limit, *keys)
        return right


def _limits(name: str, address: str) -> Iterator[tuple[RateLimitItem, tuple[str, ...]]]:
    """Each limit, and what it counts for. The beginning of a name is enough of it."""
    account = name[:LONGEST]
    for limits, keys in (
        (PER_ACCOUNT_AND_ADDRESS, ("both", account, address)),
        (PER_ACCOUNT, ("account", account)),
        (PER_ADDRESS, ("address", address)),
    ):
        for limit in limits:
            yield limit, keys


# Identifies the visitor: by session, by HTTP basic authentication, or by a trusted reverse proxy.
#
# A home without users, served on this machine only, is readable by everybody on it.

KEY = "pages.key"
SESSION = timedelta(hours=12)
LOGIN = "/login"
WATCHED = ("/health", "/metrics")  # by what watches the line; health.py says who may
OPEN, OPEN_FOLDERS = (LOGIN, "/_favicon.ico", *WATCHED), ("/assets/", "/_dash-component-suites/")
REFUSED = 400  # and above
SHELL = ("/_dash-layout", "/_dash-dependencies")
UPDATE, OF_THE_FRAME = "/_dash-update-component", "..page.children."
ASK_AGAIN: dict[str, Any] = {  # as Dash has it for what a callback sets beside its outputs
    "multi": True, "response": {}, "sideUpdate": {"again": {"disabled": False, "interval": 1000}},
}  # fmt: skip
CSRF_COOKIE = "_csrf_token"  # where Dash looks for what it sends back as X-CSRFToken


def fault() -> Busy | None:
    """Why it could not be found out: the database does not answer."""
    found: Busy | None = g.get("fault")
    return found


def guard(server: Flask, home: Home) -> LoginLimiter:
    """Requires a name of every visitor; sets up sessions and CSRF tokens."""
    gate, pages = LoginLimiter(), settings.pages(home)
    if pages.proxy and pages.proxy.secret_file:
        whole_files.read(home.path / pages.proxy.secret_file)  # an invalid one is reported now
    # What signs the cookies: a file of the home; with no home yet, for this process alone
    server.config.update(
        SECRET_KEY=whole_files.made(home.path / KEY)
        if home.path.is_dir()
        else secrets.token_hex(32),
        PERMANENT_SESSION_LIFETIME=SESSION,
        SESSION_COOKIE_NAME=session_cookie(home),
        SESSION_COOKIE_HTTPONLY=True,
        SESSION_COOKIE_SAMESITE="Lax",
        SESSION_COOKIE_SECURE=pages.https,
        WTF_CSRF_CHECK_DEFAULT=False,  # `not_forged` does, but for a script with its password
        WTF_CSRF_TIME_LIMIT=None,  # as long as the session: a tablet stays on its page
        WTF_CSRF_SSL_STRICT=False,  # Talisman's referrer policy sends none
    )

    server.before_request(lambda: _let_in(gate, home))
    tokens = CSRFProtect(server)

    @server.before_request
    def not_forged() -> None:
        # A browser sends a stored password by itself, but a form of another site cannot send JSON.
        if not (g.get("by_password") and request.is_json):
            tokens.protect()

    server.register_error_handler(CSRFError, lambda error: refusal(400, str(error.description)))

    @server.after_request
    def with_token(response: Response) -> Response:
        if response.mimetype == "text/html":
            response.set_cookie(CSRF_COOKIE, generate_csrf(), samesite="Strict", secure=pages.https)
        return response

    server.register_error_handler(Exception, _cannot_be_answered)
    server.after_request(_logged)
    return gate


def session_cookie(home: Home) -> str:
    """The name of a home's session cookie: a browser sends a cookie to every port of its host."""
    return f"mimucal_session_{hashlib.sha256(str(home.path).encode()).hexdigest()[:8]}"


def _let_in(gate: LoginLimiter, home: Home) -> AnyResponse | None:
    """Sets `g.visitor`; an answer where somebody is turned away."""
    # By the route, not by the path: an unknown path is one of Dash's pages, and not public.
    rule = request.url_rule.rule if request.url_rule else ""
    if request.path in OPEN or rule.startswith(OPEN_FOLDERS):
        return None
    try:
        g.visitor = _identified(registered_users(home), gate, home)
    except Busy as error:
        return _without_database(error)
    except Unusable as error:
        LOGGER.error("nobody is let in: %s", error)
        return refusal(503, "the pages cannot find out who you are; their log says why")
    return None if g.visitor else _turned_away()


def log_in(user: User, home: Home) -> None:
    """Begin a session of a user; whatever an earlier one held is gone."""
    address = request.remote_addr or ""
    begun = users.begin(user.name, address, home)
    LOGGER.info("log in %s from %s", user.name, address)
    session.clear()
    session.permanent = True
    session.update(id=begun, name=user.name, password=_mark(user))


def log_out(home: Home) -> None:
    """End the visitor's session, here and for every copy of its cookie."""
    address = request.remote_addr or ""
    users.end(str(session.get("id", "")), address, home)
    LOGGER.info("log out %s from %s", plain(session.get("name", "")), address)
    session.clear()


def passed(user: User | None, password: str, name: str, gate: LoginLimiter, home: Home) -> bool:
    """Whether a name comes with its password; if not, that is logged, and when the gate shuts."""
    address = request.remote_addr or ""
    if gate.check(user, password, name, address) and user is not None:
        return True
    # An unknown user name may be a mistyped password, and is not logged.
    subject = user.name if user else UNKNOWN
    refused(home, "log in", subject, address=address, why="wrong name or password")
    if gate.is_locked(name, address):
        refused(home, "further tries to log in", subject, address=address, why="too many failed")
    return False


def _cannot_be_answered(error: Exception) -> AnyResponse:
    """What no page of ours sends: Dash fails over it before a callback or a file is reached."""
    if isinstance(error, HTTPException):
        return error.get_response()
    if request.path != UPDATE and not request.path.startswith(OPEN_FOLDERS):
        raise error
    LOGGER.warning("%s: %s", request.path, type(error).__name__)
    return refusal(400, "this request cannot be answered")


def _logged(response: Response) -> Response:
    """Every request that was refused, or sent to the login, is a line of the log."""
    is_away = response.location is not None and response.location.startswith(f"{LOGIN}?")
    if response.status_code >= REFUSED or is_away:
        visitor: Visitor | None = g.get("visitor")
        LOGGER.warning(
            "%s %s %s refused to %s from %s", response.status_code, plain(request.method),
            plain(request.path), visitor.name if visitor and visitor.name else UNKNOWN,
            request.remote_addr,
        )  # fmt: skip
    return response


def _identified(known: dict[str, User], gate: LoginLimiter, home: Home) -> Visitor | None:
    """By the proxy's header, the session, or name and password; else None."""
    proxy = settings.pages(home).proxy
    if proxy and _is_of(proxy, home):
        return _visitor(known.get(request.headers.get(proxy.header, "")))
    if not known and proxy is None:
        return Visitor()
    user = known.get(session.get("name", ""))
    if (
        user
        and session.get("password") == _mark(user)
        and users.is_open(str(session.get("id", "")), user.name, home)
    ):
        return _visitor(user)
    if not request.path.startswith(PREFIX):
        return None
    user = by_password(known, gate, home)
    g.by_password = user is not None
    return _visitor(user)


def _is_of(proxy: Proxy, home: Home) -> bool:
    """Whether a request comes from the proxy: from its address, and with its secret if it has one.

    A header by its name that comes from elsewhere is no fault of the visitor's, and counts nothing.
    """
    address = request.remote_addr or ""
    if address not in map(str, proxy.addresses):
        return False
    if proxy.secret_file is None:
        return True
    secret = whole_files.read(home.path / proxy.secret_file)
    given = request.headers.get(proxy.secret_header, "")
    return hmac.compare_digest(given.encode(), secret.encode())


def by_password(known: dict[str, User], gate: LoginLimiter, home: Home) -> User | None:
    """A script says its name and password with each request (HTTP basic authentication)."""
    given, address = request.authorization, request.remote_addr or ""
    if given is None or given.username is None or gate.is_locked(given.username, address):
        return None
    user = known.get(given.username)
    if not passed(user, given.password or "", given.username, gate, home):
        return None
    LOGGER.info("%s answers to %s from %s", plain(request.path), plain(given.username), address)
    return user


def _visitor(user: User | None) -> Visitor | None:
    return Visitor(name=user.name, role=user.role) if user else None


def _mark(user: User) -> str:
    """A mark of the password that ends sessions when it changes, and does not reveal it."""
    return hashlib.sha256(user.password.encode()).hexdigest()[:16]


def _turned_away() -> AnyResponse:
    if request.path.startswith(PREFIX):
        refused = refusal(401, "say who you are: HTTP basic authentication, or log in at /login")
        refused.headers["WWW-Authenticate"] = 'Basic realm="mimucal", charset="UTF-8"'
        return refused
    if request.method == "GET" and not request.path.startswith("/_dash"):
        return redirect(f"{LOGIN}?next={quote(request.path)}")
    return refusal(401, "the session has ended; log in again")


def _without_database(error: Busy) -> AnyResponse | None:
    """The frame of the pages is there without it, to say so and to ask again; nothing else is.

    Whatever else a page asks for by itself has the frame ask for the whole page again.
    """
    g.fault = error
    if request.path == UPDATE:
        asked = (request.get_json(silent=True) or {}).get("output", "")
        return None if str(asked).startswith(OF_THE_FRAME) else jsonify(ASK_AGAIN)
    is_page = request.method == "GET" and "text/html" in request.headers.get("Accept", "")
    return None if is_page or request.path in SHELL else refusal(503, str(error))
