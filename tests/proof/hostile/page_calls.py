"""Hostile calls of the operations pages, by what they try."""

import base64
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any
from urllib.parse import urlencode

from flask import Flask
from flask.sessions import SecureCookieSessionInterface

from flows.pages.access import session_cookie
from flows.pages.register import PAGES
from schemas.access import MAY, ROLES
from tests.proof.hostile.attacked import PASSWORD, Attacked
from tests.proof.hostile.browser import FORM, JSON, Answer, Browser, pressed

NOT_DONE = ("does not allow", "cannot be answered")


@dataclass(frozen=True)
class Call:
    """kind: what it tries, as the evidence counts it. send: makes it."""

    kind: str
    what: str
    send: Callable[[], Answer]


def is_refused(answer: Answer) -> bool:
    """Whether an answer gives nothing: an error, the way to the login, or a refused order."""
    leads_away = answer.status in (301, 302, 308) and answer.location.startswith("/login")
    declined = answer.status == 200 and any(sentence in answer.text for sentence in NOT_DONE)
    return 400 <= answer.status < 500 or leads_away or declined


def orders_on(there: Attacked) -> dict[str, dict[str, Any]]:
    """An order of each kind that would act, with a name that is not the visitor's."""
    step = {"reason": "hostile", "by": "Ghost"}
    return {
        "check": {"certificate": there.certificates["draft"], **step},
        "issue": {"certificate": there.certificates["checked"], **step},
        "withdraw": {"certificate": there.certificates["issued"], **step},
        "certify": {"run": "r1", "by": "Ghost"},
        "acquire": {"station": "T1", "procedure": "jjf2003", "by": "Ghost"},
        "reprocess": {"station": "T1", "by": "Ghost"},
    }


def paths(there: Attacked) -> list[str]:
    """Everything that somebody could look at."""
    names = [page.name for page in PAGES]
    return [
        *(f"/{name}" for name in names), *(f"/api/v1/{name}" for name in names),
        "/api/v1/openapi.json", "/_dash-layout", "/_dash-dependencies",
        f"/certificate/{there.certificates['issued']}.pdf", "/explained/r1.html",
    ]  # fmt: skip


def all_calls(there: Attacked, address: str, bare: str) -> Iterator[Call]:
    """Every hostile call. bare: pages of a home without users and without a proxy."""
    for calls in (
        _no_login, _other_role, _no_token, _after_logout, _forged_cookies, _proxy_header,
        _path_tricks, _methods, _wrong_passwords, _wrong_types,
    ):  # fmt: skip
        yield from calls(there, address)
    yield from _hosts(bare)


def _no_login(there: Attacked, address: str) -> Iterator[Call]:
    stranger = Browser(address)
    for path in paths(there):
        yield Call("no login", path, partial(stranger.send, "GET", path))
    token = Browser(address).token()
    for action, fields in orders_on(there).items():
        yield Call("no login", f"order {action}", partial(stranger.order, action, fields, token))


def _other_role(there: Attacked, address: str) -> Iterator[Call]:
    for role in ROLES:
        visitor = Browser(address)
        visitor.log_in(role)
        token = visitor.token()
        for action, fields in orders_on(there).items():
            if role not in MAY[action]:  # type: ignore[index]
                sent = partial(visitor.order, action, fields, token)
                yield Call("other role, forged name", f"{role}: {action}", sent)


def _no_token(there: Attacked, address: str) -> Iterator[Call]:
    boss, other = Browser(address), Browser(address)
    boss.log_in("administrator")
    stolen = other.token()
    for action, fields in orders_on(there).items():
        for what, token in (("none", None), ("another visitor's", stolen)):
            sent = partial(boss.order, action, fields, token)
            yield Call("forged request (CSRF)", f"{action}, token: {what}", sent)
    yield Call("forged request (CSRF)", "logout", partial(boss.send, "POST", "/logout"))


def _after_logout(there: Attacked, address: str) -> Iterator[Call]:
    boss = Browser(address)
    boss.log_in("administrator")
    token, kept = boss.token(), dict(boss.cookies)
    boss.log_out()
    copy = Browser(address, kept)
    for path in paths(there):
        yield Call("session after logout", path, partial(copy.send, "GET", path))
    for action, fields in orders_on(there).items():
        copied = Browser(address, dict(kept))
        yield Call("session after logout", action, partial(copied.order, action, fields, token))


def _forged_cookies(there: Attacked, address: str) -> Iterator[Call]:
    app = Flask("forger")
    app.secret_key = "guessed"
    signer = SecureCookieSessionInterface().get_signing_serializer(app)
    assert signer is not None
    claim = {"name": "administrator", "id": "0" * 32, "password": "0" * 16}
    plain = base64.urlsafe_b64encode(b'{"name":"administrator"}').decode().rstrip("=")
    for what, value in (
        ("signed by a guessed key", signer.dumps(claim)), ("unsigned", plain),
        ("without a signature", f"{plain}.."), ("empty", ""), ("long", "A" * 4000),
        ("not base64", "%%%"),
    ):  # fmt: skip
        forger = Browser(address, {session_cookie(there.home): value})
        yield Call("forged cookie", what, partial(forger.send, "GET", "/api/v1/runs"))


def _proxy_header(there: Attacked, address: str) -> Iterator[Call]:
    local = Browser(address)
    secrets = {"none": {}, "wrong": {"X_Proxy_Secret": "0" * 64}, "empty": {"X_Proxy_Secret": ""}}
    for what, secret in secrets.items():
        for path in ("/line", "/do", "/api/v1/runs", "/api/v1/do", "/_dash-layout"):
            headers = {"X_Remote_User": "administrator"} | secret
            sent = partial(local.send, "GET", path, **headers)
            yield Call("proxy's header from a local process", f"{path}, secret: {what}", sent)
    for name in ("X_Forwarded_For", "X_Real_IP", "Forwarded"):
        sent = partial(
            local.send, "GET", "/api/v1/runs", X_Remote_User="administrator", **{name: "127.0.0.1"}
        )
        yield Call("proxy's header from a local process", name, sent)


def _path_tricks(there: Attacked, address: str) -> Iterator[Call]:
    stranger = Browser(address)
    for path in (
        "/assets/../orders.key", "/assets/%2e%2e/%2e%2e/orders.key", "/assets/..%2forders.key",
        "/assets/....//orders.key", "/assets//etc/passwd", "/assets/%00", "/assets/..\\orders.key",
        "/certificate/..%2f..%2forders.key", "/certificate/%2e%2e/catalog.sqlite",
        "/certificate/../orders.key.pdf", "/explained/..%2f..%2fpages.key.html",
        "/login/../api/v1/runs", "/login/", "/login%2f..%2fapi%2fv1%2fruns", "/loginapi",
        "//api/v1/runs", "/./api/v1/runs", "/API/V1/RUNS", "/api/v1/%72uns", "/api/v1/runs/",
        "/api/v1/..;/runs", "/orders.key", "/catalog.sqlite", "/pages.toml", "/.env",
        "/_dash-component-suites/../orders.key", "/_dash-component-suites/x/../../orders.key",
        "/_favicon.ico/../api/v1/runs",
    ):  # fmt: skip
        yield Call("path trick", path, partial(stranger.send, "GET", path))


def _methods(there: Attacked, address: str) -> Iterator[Call]:
    stranger, looker = Browser(address), Browser(address)
    looker.log_in("viewer")
    for method in ("PUT", "DELETE", "PATCH", "TRACE", "POST", "CONNECT", "PROPFIND"):
        for who, visitor in (("nobody", stranger), ("viewer", looker)):
            for path in ("/api/v1/runs", "/do"):
                sent = partial(visitor.send, method, path)
                yield Call("HTTP method", f"{method} {path} by {who}", sent)


def _wrong_passwords(there: Attacked, address: str) -> Iterator[Call]:
    for name, password in (
        ("administrator", "wrong"), ("administrator", ""), ("Administrator", PASSWORD),
        ("nobody of that name", "wrong"), ("' OR 1=1 --", "' OR 1=1 --"), ("issuer\x00", "wrong"),
        ("x" * 100_000, "wrong"), ("", ""),
    ):  # fmt: skip
        yield Call(
            "wrong password", f"form: {name[:30]!r}", partial(_tried, address, name, password)
        )
    for number in range(7):
        given = base64.b64encode(f"verifier:wrong {number}".encode()).decode()
        stranger = Browser(address)
        sent = partial(stranger.send, "GET", "/api/v1/do", Authorization=f"Basic {given}")
        yield Call("wrong password", f"script, try {number + 1}", sent)
    for given in ("Basic", "Basic !!!", "Bearer x", "Basic Og==", "Digest username=administrator"):
        sent = partial(Browser(address).send, "GET", "/api/v1/do", Authorization=given)
        yield Call("wrong password", given, sent)


def _tried(address: str, name: str, password: str) -> Answer:
    return Browser(address).log_in(name, password)


def _wrong_types(there: Attacked, address: str) -> Iterator[Call]:
    looker = Browser(address)
    looker.log_in("administrator")  # whose role allows all of it
    token = looker.token()
    good = pressed("withdraw", orders_on(there)["withdraw"])
    for what, content in (
        ("a list", []), ("a text", "x"), ("a number", 5), ("null", None), ("nothing", {}),
        ("output: a number", good | {"output": 5}), ("no such output", good | {"output": "x.y"}),
        ("no output, with inputs", good | {"output": "", "outputs": []}),
        ("inputs: a text", good | {"inputs": "x"}), ("state: null", good | {"state": None}),
        ("changed: a number", good | {"changedPropIds": 5}),
        ("action: a list", good | {"changedPropIds": ['{"do":["withdraw"]}.n_clicks']}),
        ("fields: lists", pressed("withdraw", {"certificate": ["x"], "reason": {"a": 1}})),
        ("fields: numbers", pressed("withdraw", {"certificate": 5, "reason": None})),
        ("ids: texts", good | {"state": [["x"], ["y"]]}),
    ):  # fmt: skip
        yield Call("wrong type in JSON", what, partial(looker.update, content, token))
    for what, body in (("broken", '{"a":'), ("deep", "[" * 5000), ("NaN", "NaN")):
        sent = partial(
            looker.send, "POST", "/_dash-update-component", body, JSON, X_CSRFToken=token
        )
        yield Call("wrong type in JSON", what, sent)
    form = urlencode({"csrf_token": token})
    sent = partial(looker.send, "POST", "/_dash-update-component", form, FORM)
    yield Call("wrong type in JSON", "a form", sent)


def _hosts(bare: str) -> Iterator[Call]:
    stranger = Browser(bare)
    for host in (
        "elsewhere.example", "elsewhere.example:80", "127.0.0.1.elsewhere.example", "localhost.",
        "", "a b", "127.0.0.1@elsewhere.example", "2130706433", "0.0.0.0",
    ):  # fmt: skip
        sent = partial(stranger.send, "GET", "/api/v1/runs", Host=host)
        yield Call("host header", repr(host), sent)


NEXT = (
    "//line", "///line", "//elsewhere.example/line", "https://elsewhere.example", "/\\line",
    "\\\\elsewhere.example", "line", "/line/../..//elsewhere.example", "javascript:alert(1)",
    "/line\r\nSet-Cookie: a=b", "/%2f/elsewhere.example", " //line",
)  # fmt: skip


def logins(address: str) -> Iterator[Call]:
    """Logins of a viewer whose `next` should lead to another host; the login itself is good."""
    for wanted in NEXT:
        visitor = Browser(address)
        sent = partial(visitor.log_in, "viewer", wanted=wanted)
        yield Call("next that leads elsewhere", repr(wanted), sent)
