"""The base of every model, and errors that are addressed to the user."""

import re
from collections.abc import Callable, Mapping
from string import Template
from typing import Annotated
from urllib.parse import quote, unquote

from pydantic import BaseModel, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

Progress = Callable[[int, int], None]  # is called with how much is done, and of how much

# URLs with a password: escaped where they are used, without it where they are shown.
#
# A password may contain any character, even the delimiters of a URL: the host is what follows an
# @, looks like a host name, and is followed by a path, a query or nothing.

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


Finite = Annotated[float, Field(allow_inf_nan=False)]


class Frozen(BaseModel):
    """An immutable model that refuses fields it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Worded(Exception):  # noqa: N818 (its kinds say what is wrong)
    """A sentence for the terminal.

    cause: the same as a message or statement for the pages, which show neither commands of a shell
    nor places of the server; null where only the sentence exists.
    """

    def __init__(self, sentence: str = "", cause: object = None) -> None:
        super().__init__(sentence)
        self.cause = cause


class Unusable(Worded):
    """Input that cannot be used.

    The text is one sentence for the person at the bench: the file, the field, the value and
    the way out. The command line prints it and exits with 2.
    """


class NotThere(Unusable):
    """What is named does not exist."""


class NotAllowed(Unusable):
    """The role of whoever asks does not allow it."""


class BrokenOff(Worded):
    """The operator or the machine ended a run; the sentence says where its recording is."""


def first_fault(error: ValidationError) -> str:
    """The first fault of a validation error as “field.path: what is wrong (found value)”."""
    return faults(error)[0]


def faults(error: ValidationError) -> list[str]:
    """Every fault of a validation error as `first_fault` has it."""
    return list(map(_fault, error.errors(include_url=False)))


def _fault(fault: ErrorDetails) -> str:
    place = ".".join(str(part) for part in fault["loc"]) or "document"
    if fault["type"] == "missing":
        return f"{place} is missing"
    message = fault["msg"].removeprefix("Value error, ")
    value = fault.get("input")
    value = shown(value) if isinstance(value, str) else value
    found = "" if isinstance(value, dict) else f" (found {value!r})"[:80]
    return f"{place}: {message}{found}"
