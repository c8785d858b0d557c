"""Who may do what on the operations pages."""

from collections.abc import Mapping
from typing import Literal, get_args

from pydantic import AwareDatetime, Field

from schemas.base import Frozen

Role = Literal["viewer", "operator", "verifier", "issuer", "administrator"]
ROLES: tuple[Role, ...] = get_args(Role)
Action = Literal["acquire", "reprocess", "certify", "check", "issue", "withdraw", "stop"]

# That three different persons draft, check and issue is a rule of the certificate, whatever their
# roles: an administrator who drafted does not check.
MAY: Mapping[Action, tuple[Role, ...]] = {
    "acquire": ("operator", "administrator"),
    "reprocess": ("operator", "administrator"),
    "certify": ("operator", "administrator"),
    "check": ("verifier", "administrator"),
    "issue": ("issuer", "administrator"),
    "withdraw": ("issuer", "administrator"),
    "stop": ("operator", "administrator"),  # on the station's own computer anybody may
}


class User(Frozen):
    """A user of the pages. password: its Argon2 hash."""

    name: str = Field(min_length=1, max_length=100, pattern=r"^\S(.*\S)?$")
    role: Role
    password: str = Field(repr=False)
    added_at: AwareDatetime


class Visitor(Frozen):
    """The visitor of a page; without a name, somebody on this machine in a home without users."""

    name: str = ""
    role: Role = "viewer"

    def may(self, action: Action) -> bool:
        """Whether the role allows an action."""
        return bool(self.name) and self.role in MAY[action]


class Proxy(Frozen):
    """A reverse proxy that authenticates visitors: its addresses, and the header with the user's
    name.
    """

    addresses: tuple[str, ...] = Field(min_length=1)
    header: str = Field(min_length=1, pattern=r"^[A-Za-z0-9-]+$")


class PagesFile(Frozen):
    """`pages.toml` of the home: how the pages are served.

    https: whether a proxy in front terminates TLS, so that cookies are sent over HTTPS only.
    """

    format: Literal["mimu-pages/1"] = "mimu-pages/1"
    https: bool = False
    proxy: Proxy | None = None
