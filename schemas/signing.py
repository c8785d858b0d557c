"""The key with which a laboratory signs its certificates: `[signing]` in laboratory.toml."""

from typing import Self

from pydantic import Field, model_validator

from schemas.base import Frozen


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
