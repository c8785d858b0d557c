"""The signature that an order carries which is given in a person's name."""

from pydantic import AwareDatetime, Field

from schemas.base import Frozen


class Signature(Frozen):
    """Who gave an order, when and where, so that nobody else can give it.

    nonce: a number that is used once. signed_on: the login at the operating system and its
    computer, as `wang@station-2`. mac: HMAC-SHA256 by the key of the home over the flow's name, the
    order without its signature, and the other fields here, as canonical JSON.
    """

    person: str = Field(min_length=1)
    signed_at: AwareDatetime
    nonce: str = Field(pattern=r"^[0-9a-f]{32}$")
    signed_on: str
    mac: str = Field(pattern=r"^[0-9a-f]{64}$", repr=False)
