"""The laboratory's signature: PAdES (ETSI EN 319 142, baseline B-B or B-T) in the PDF."""

import asyncio
import io
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from pkcs11 import PKCS11Error
from pyhanko.pdf_utils.incremental_writer import IncrementalPdfFileWriter
from pyhanko.sign import fields, signers
from pyhanko.sign.pkcs11 import PKCS11Signer, TokenCriteria, open_pkcs11_session
from pyhanko.sign.timestamps import HTTPTimeStamper, TimestampRequestError

from schemas.base import Unusable
from schemas.signature import SigningSettings, Token

FIELD = "Signature"
DIGEST = "sha256"


@dataclass(frozen=True, eq=False)
class Signing:
    """The laboratory's key, ready to sign.

    signer: pyHanko's, of a file or of a token. at: when it signs, with its offset from UTC.
    time_stamper: pyHanko's, of a time-stamping service.
    """

    signer: Any
    at: datetime
    time_stamper: Any = None

    def certificates(self) -> Sequence[bytes]:
        """The signer's certificate and those that issued it, up to the root, as DER."""
        chain = [self.signer.signing_cert]
        every = {each.subject.hashable: each for each in self.signer.cert_registry}
        while chain[-1].issuer != chain[-1].subject:
            issuer = every.get(chain[-1].issuer.hashable)
            if issuer is None:
                break
            chain.append(issuer)
        return [each.dump() for each in chain]


def signing_of(
    settings: SigningSettings, folder: Path, passphrase: str | None, at: datetime
) -> Signing:
    """The key that the settings name, opened. folder: from which a relative path counts.

    Raises Unusable, in one sentence, for a key that cannot be opened or whose certificate is not
    valid at that time.
    """
    if settings.pkcs12 is not None:
        signer = _of_file(folder / settings.pkcs12, passphrase)
    else:
        assert settings.pkcs11 is not None
        signer = _of_token(settings.pkcs11, passphrase)
    certificate = signer.signing_cert
    first, last = certificate.not_valid_before, certificate.not_valid_after
    if not first <= at <= last:
        raise Unusable(
            f"The certificate of the signing key ({certificate.subject.human_friendly}) is valid "
            f"from {first.date()} to {last.date()}, not on {at.date()}: name a key with a valid "
            "certificate under [signing] in laboratory.toml."
        )
    return Signing(signer, at, _time_stamper(settings.time_stamps))


def sign_pdf(pdf: bytes, signing: Signing) -> bytes:
    """The PDF with an invisible signature over all of it, added without touching its bytes.

    Raises Unusable where the time-stamping service does not answer.
    """

    class _AtGivenTime(signers.PdfSigner):
        def init_signing_session(self, *arguments: Any, **options: Any) -> Any:
            session = super().init_signing_session(*arguments, **options)
            session.system_time = signing.at
            return session

    metadata = signers.PdfSignatureMetadata(
        field_name=FIELD,
        md_algorithm=DIGEST,
        subfilter=fields.SigSeedSubFilter.PADES,
        certify=True,
        docmdp_permissions=fields.MDPPerm.NO_CHANGES,
    )
    signer = _AtGivenTime(metadata, signing.signer, timestamper=signing.time_stamper)
    output = io.BytesIO()
    try:
        signer.sign_pdf(IncrementalPdfFileWriter(io.BytesIO(pdf)), output=output)
    except (TimestampRequestError, OSError) as error:
        raise Unusable(
            f"The time-stamping service does not answer ({error}): try again, or leave "
            "time_stamps out of [signing] in laboratory.toml."
        ) from error
    return output.getvalue()


def _of_file(path: Path, passphrase: str | None) -> Any:
    secret = None if passphrase is None else passphrase.encode()
    if not path.is_file():
        raise Unusable(
            f"The signing key {path} does not exist: correct pkcs12 under [signing] in "
            "laboratory.toml."
        )
    # pyhanko logs a traceback beside the None that stands for a wrong passphrase.
    logging.getLogger("pyhanko").addHandler(logging.NullHandler())
    signer = signers.SimpleSigner.load_pkcs12(str(path), passphrase=secret)
    if signer is None:
        raise Unusable(
            f"The signing key {path} cannot be opened: set its passphrase in "
            "MIMUCAL_SIGNING_PASSPHRASE, or give a PKCS#12 file with key and certificate."
        )
    return signer


def _of_token(token: Token, pin: str | None) -> Any:
    try:
        session = open_pkcs11_session(
            token.module, token_criteria=TokenCriteria(label=token.token), user_pin=pin
        )
        signer = PKCS11Signer(
            session, cert_label=token.key, key_label=token.key, other_certs_to_pull=None
        )
        asyncio.run(signer.ensure_objects_loaded())
    except (PKCS11Error, OSError, RuntimeError) as error:
        raise Unusable(
            f"The signing key {token.key} of token {token.token} cannot be used "
            f"({type(error).__name__}): correct pkcs11 under [signing] in laboratory.toml, and set "
            "the PIN in MIMUCAL_SIGNING_PASSPHRASE."
        ) from error
    return signer


def _time_stamper(address: str | None) -> Any:
    if address is None:
        return None

    return HTTPTimeStamper(address)
