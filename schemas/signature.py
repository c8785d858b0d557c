"""The signature of an order that is given in a person's name, and the key of certificates."""

from typing import Self

from pydantic import AwareDatetime, Field, model_validator

from schemas.base import Frozen


class Signature(Frozen):
    """Who gave an order, when and where, protected against forgery.

    nonce: a number that is used once. signed_on: the login at the operating system and its
    computer, as `wang@station-2`. mac: HMAC-SHA256 by the key of the home over the flow's name, the
    order without its signature, and the other fields here, as canonical JSON.
    """

    person: str = Field(min_length=1)
    signed_at: AwareDatetime
    nonce: str = Field(pattern=r"^[0-9a-f]{32}$")
    signed_on: str
    mac: str = Field(pattern=r"^[0-9a-f]{64}$", repr=False)


class Token(Frozen):
    """A key in a PKCS#11 token (a card, an HSM, SoftHSM).

    module: the manufacturer's library. token: label of the token; key: label of the key and of its
    certificate.
    """

    module: str = Field(min_length=1)
    token: str = Field(min_length=1)
    key: str = Field(min_length=1)


class SigningSettings(Frozen):
    """The signing key: pkcs12, a file relative to the home folder unless absolute; or a token.

    The passphrase or PIN is taken from the environment (MIMUCAL_SIGNING_PASSPHRASE). time_stamps:
    address of a time-stamping service (RFC 3161), for the PDF.
    """

    pkcs12: str | None = None
    pkcs11: Token | None = None
    time_stamps: str | None = None

    @model_validator(mode="after")
    def _one_key(self) -> Self:
        if (self.pkcs12 is None) == (self.pkcs11 is None):
            raise ValueError("signing names one key: give either pkcs12 or pkcs11")
        return self
