"""URLs with a password: escaped where they are used, without it where they are shown.

A password may contain any character, even the delimiters of a URL: the host is what follows an @,
looks like a host name, and is followed by a path, a query or nothing.
"""

import re
from collections.abc import Mapping
from string import Template
from urllib.parse import quote, unquote

HIDDEN = "***"
QUERY = re.compile(r"\?[\w.+:-]+=[^?&]*(?:&[\w.+:-]+=[^?&]*)*$")
NAME = r"(?:\[[0-9A-Fa-f:.]+\]|[\w.-]+)(?::\d+)?"
HOST = re.compile(rf"(?:{NAME}(?:,{NAME})*)?(?=[/?#]|$)", re.ASCII)
FULL_HOST = re.compile(r"localhost|.*[.:].*")  # no bare word
ADDRESSES = re.compile(r"(?:/[^/@\s]+@[\w-]+(?:\.[\w-]+)+)+/?")  # in a path: whom mail goes to
ESCAPE = re.compile(r"(%[0-9A-Fa-f]{2})")
SECRET = re.compile(r"pass|pwd|secret|token|key|auth", re.IGNORECASE)


def escaped(url: str) -> str:
    """The URL with user and password escaped; escapes that are there already stay."""
    head, login, rest = _parts(url)
    if login is None:
        return url
    parts = [
        "".join(each if ESCAPE.fullmatch(each) else quote(each, safe="") for each in pieces)
        for pieces in (ESCAPE.split(part) for part in login.split(":", 1))
    ]
    return f"{head}{':'.join(parts)}@{rest}"


def shown(url: str) -> str:
    """The URL without its secrets: the password, and what its query has under such a name."""
    head, login, rest = _parts(url)
    user, colon, password = (login or "").partition(":")
    before, mark, query = rest.partition("?")
    fields = [
        f"{field.partition('=')[0]}={HIDDEN}" if SECRET.search(field.partition("=")[0]) else field
        for field in query.split("&")
    ]
    hidden = "" if login is None else f"{user}{colon}{HIDDEN if password else ''}@"
    return f"{head}{hidden}{before}{mark}{'&'.join(fields)}"


def has_secret(url: str) -> bool:
    """Whether a URL carries a password, in its place or in its query."""
    return shown(url) != url


def login_apart(url: str) -> tuple[str, str | None, str | None]:
    """The URL without user and password, and both as they are meant; None where there is none."""
    head, login, rest = _parts(url)
    if login is None:
        return url, None, None
    user, colon, password = login.partition(":")
    return f"{head}{rest}", unquote(user), unquote(password) if colon else None


def filled(template: str, values: Mapping[str, str]) -> str:
    """A URL with ${NAME} filled in, the user, password and query taken literally and escaped.

    A template that is no URL itself is filled in as it is. Raises KeyError for a name without a
    value, and ValueError for a dollar without a name.
    """
    whole = Template(template).substitute(values)
    if "://" not in template:
        return escaped(whole)
    names = {name: f"value{place}of" for place, name in enumerate(values)}
    head, login, rest = _parts(Template(template).substitute(names))
    before, mark, query = rest.partition("?")
    literal = {token: quote(values[name], safe="") for name, token in names.items()}
    plain = {token: values[name] for name, token in names.items()}
    user = "" if login is None else _put(escaped(f"x://{login}@h")[4:-2], literal) + "@"
    return f"{_put(head, plain)}{user}{_put(before, plain)}{mark}{_put(query, literal)}"


def _put(text: str, values: Mapping[str, str]) -> str:
    return re.sub(r"value\d+of", lambda found: values.get(found[0], found[0]), text)


def _parts(url: str) -> tuple[str, str | None, str]:
    """`scheme://`, user and password where there are any, and everything from the host on."""
    scheme, mark, rest = url.partition("://")
    if not mark:
        return "", None, url
    place = _host_at(rest)
    login = rest[: place - 1] if place else None
    return scheme + mark, login, rest[place:]


def _host_at(rest: str) -> int:
    """Where the host begins in what is behind `scheme://`; 0 where there is no user."""
    query = QUERY.search(rest)
    before = rest[: query.start()] if query else rest
    host = HOST.match(before)
    if host and ("@" not in before or ADDRESSES.fullmatch(before[host.end() :])):
        return 0
    if "@" not in before:
        before = rest  # the question mark is the password's
    found = [(at.end(), HOST.match(before, at.end())) for at in re.finditer("@", before)]
    hosts = [(place, host) for place, host in found if host]
    for place, host in hosts:
        if FULL_HOST.fullmatch(host[0]) and ADDRESSES.fullmatch(before[host.end() :]):
            return place
    return hosts[-1][0] if hosts else 0
