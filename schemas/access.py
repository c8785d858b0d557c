"""Who may do what: on the operations pages, and in a calibration."""

from collections.abc import Mapping
from datetime import date
from ipaddress import IPv4Address, IPv6Address
from typing import Annotated, Literal, Self, get_args

from pydantic import AwareDatetime, Field, IPvAnyAddress, model_validator

from schemas.base import Frozen
from schemas.recording import Standard

Role = Literal["viewer", "operator", "verifier", "issuer", "administrator"]
ROLES: tuple[Role, ...] = get_args(Role)
HeaderName = Annotated[str, Field(min_length=1, pattern=r"^[A-Za-z0-9-]+$")]
Action = Literal["acquire", "reprocess", "certify", "check", "issue", "amend", "withdraw", "stop"]

# That three different persons draft, check and issue is a rule of the certificate, whatever their
# roles: an administrator who drafted does not check.
MAY: Mapping[Action, tuple[Role, ...]] = {
    "acquire": ("operator", "administrator"),
    "reprocess": ("operator", "administrator"),
    "certify": ("operator", "administrator"),
    "check": ("verifier", "administrator"),
    "issue": ("issuer", "administrator"),
    "amend": ("operator", "administrator"),
    "withdraw": ("issuer", "administrator"),
    "stop": ("operator", "administrator"),  # on the station's own computer anybody may
}


Authority = Literal["acquire", "check", "issue"]


class Authorised(Frozen):
    """What a person is authorised to do by the laboratory (ISO/IEC 17025:2017, 6.2.5 e, 6.2.6).

    standards: the specifications that it holds for; none: every one. until: the last day. One
    person may have several entries.
    """

    name: str = Field(min_length=1, pattern=r"\S")
    title: str | None = None
    title_zh: str | None = None
    may: tuple[Authority, ...] = Field(min_length=1)
    standards: tuple[Standard, ...] = ()
    until: date | None = None


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

    secret_file: a file of the home with what the proxy sends as `secret_header`. Without one the
    proxy is known by its address alone, which on this machine every process has.
    """

    addresses: tuple[IPvAnyAddress, ...] = Field(min_length=1)
    header: HeaderName
    secret_file: str | None = None
    secret_header: HeaderName = "X-Proxy-Secret"

    @model_validator(mode="after")
    def _no_process_of_this_machine_is_believed(self) -> Self:
        local = [str(each) for each in self.addresses if _is_local(each)]
        if local and self.secret_file is None:
            raise ValueError(
                f"every process of this machine has the address {local[0]}; add secret_file = "
                '"proxy.secret", a file of the home (chmod 600) with 32 random characters or more, '
                f"and let the proxy send them as {self.secret_header}"
            )
        return self


def _is_local(address: IPv4Address | IPv6Address) -> bool:
    plain = getattr(address, "ipv4_mapped", None) or address
    return plain.is_loopback or plain.is_unspecified


class PagesFile(Frozen):
    """`pages.toml` of the home: how the pages are served.

    https: whether a proxy in front terminates TLS, so that cookies are sent over HTTPS only.
    """

    format: Literal["mimu-pages/1"] = "mimu-pages/1"
    https: bool = False
    proxy: Proxy | None = None
