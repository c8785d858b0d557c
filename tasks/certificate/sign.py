"""The laboratory's signature: PAdES (ETSI EN 319 142, baseline B-B or B-T) in the PDF."""

import asyncio
import base64
import hashlib
import io
import logging
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from asn1crypto.cms import ContentInfo, SignedData, SignerInfo
from asn1crypto.x509 import Certificate
from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.serialization import Encoding
from lxml import etree
from pkcs11 import PKCS11Error
from pyhanko.pdf_utils.incremental_writer import IncrementalPdfFileWriter
from pyhanko.sign import fields, signers
from pyhanko.sign.pkcs11 import PKCS11Signer, TokenCriteria, open_pkcs11_session
from pyhanko.sign.timestamps import HTTPTimeStamper, TimestampRequestError
from pyhanko.sign.validation import validate_pdf_signature
from pyhanko.sign.validation.settings import KeyUsageConstraints
from pyhanko.sign.validation.status import SignatureCoverageLevel
from pyhanko_certvalidator import ValidationContext
from signxml import DigestAlgorithm, SignatureMethod, methods
from signxml.xades import (
    XAdESDataObjectFormat,
    XAdESSignatureConfiguration,
    XAdESSigner,
    XAdESVerifier,
)

from schemas.base import Unusable
from schemas.certificate import SigningSettings, Token
from tasks.certificate.dcc.quantities import Element, canonical

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


# The laboratory's signature in the DCC: XAdES B-B, enveloped (XMLDSig, ETSI EN 319 132).


class _Key:
    """A key as signxml calls it, wherever pyHanko's signer keeps it."""

    def __init__(self, signer: Any) -> None:
        self._signer = signer
        self.key_size = signer.signing_cert.public_key.bit_size

    def sign(self, message: bytes, **_: object) -> bytes:
        signature = asyncio.run(self._signer.async_sign_raw(message, DIGEST))
        return bytes(signature)


def sign_xml(dcc: bytes, signing: Signing) -> bytes:
    """The DCC with a signature over all of it, in canonical form."""

    class _AtGivenTime(XAdESSigner):
        def add_signing_time(self, properties: Any, sig_root: Any, signing_settings: Any) -> None:
            super().add_signing_time(properties, sig_root, signing_settings)
            properties[-1].text = signing.at.isoformat(timespec="seconds")

    elliptic = signing.signer.signing_cert.public_key.algorithm == "ec"
    signer = _AtGivenTime(
        method=methods.enveloped,
        signature_algorithm=(
            SignatureMethod.ECDSA_SHA256 if elliptic else SignatureMethod.RSA_SHA256
        ),
        digest_algorithm=DigestAlgorithm.SHA256,
        data_object_format=XAdESDataObjectFormat("Digital Calibration Certificate", "text/xml"),
    )
    chain = [x509.load_der_x509_certificate(each) for each in signing.certificates()]
    key: Any = _Key(signing.signer)
    signed = signer.sign(etree.fromstring(dcc), key=key, cert=chain, always_add_key_value=False)
    return canonical(signed)


# Checks a signature: whether it is valid, who made it and when; fetches nothing.

DS = "{http://www.w3.org/2000/09/xmldsig#}"
XADES = "{http://uri.etsi.org/01903/v1.3.2#}"


class Broken(Exception):  # noqa: N818 (it is the finding)
    """What does not hold; the text says why."""


@dataclass(frozen=True)
class Signed:
    """Who signed and when, and by which authority: its name and its certificate's SHA-256."""

    by: str
    at: datetime
    authority: str
    authority_sha256: str
    time_stamped: bool = False


def check_pdf_signature(pdf: bytes, embedded: Any, trusted: Sequence[bytes]) -> Signed:
    """Checks that a signature of a PDF covers all of it, and that nothing was changed since.

    embedded: pyHanko's. trusted: certificates (DER), one of which must have issued the signer's;
    empty: any issuer. Raises Broken.
    """
    if embedded.md_algorithm != DIGEST:
        raise Broken(f"its digest is {embedded.md_algorithm}, not {DIGEST}")
    _check_contents(pdf, embedded)
    others = [each.dump() for each in embedded.other_embedded_certs]
    at = embedded.self_reported_timestamp
    signed, root = _signed([embedded.signer_cert.dump(), *others], at, trusted)
    context = ValidationContext(
        trust_roots=[Certificate.load(root)],
        other_certs=[Certificate.load(each) for each in others],
        moment=at,
        best_signature_time=at,
        allow_fetching=False,
    )
    usage = KeyUsageConstraints(
        key_usage={"digital_signature", "non_repudiation"}, match_all_key_usages=False
    )
    status = validate_pdf_signature(embedded, context, key_usage_settings=usage)
    if not (status.intact and status.valid):
        raise Broken("its signature does not fit its bytes")
    if status.coverage != SignatureCoverageLevel.ENTIRE_FILE:
        raise Broken("something was added to it after it was signed")
    if not status.trusted:
        raise Broken("the certificate of its signature does not stand under its authority")
    stamp = status.timestamp_validity
    if stamp is not None and not (stamp.intact and stamp.valid):
        raise Broken("its time stamp does not hold")
    return Signed(*signed, time_stamped=stamp is not None)


def check_xml_signature(root: Element, trusted: Sequence[bytes]) -> Signed | None:
    """Checks the signature over a whole DCC; None if there is none. Raises Broken."""
    found = root.findall(f".//{DS}Signature")
    if not found:
        return None
    (signature, *more) = found
    if more:
        raise Broken("it has several signatures")
    try:
        chain = [_decoded(each.text) for each in signature.iter(f"{DS}X509Certificate")]
        _decoded(signature.findtext(f"{DS}SignatureValue"))
        properties = signature.find(f".//{XADES}QualifyingProperties")
        if properties.get("Target") != f"#{signature.get('Id')}":
            raise Broken("the properties of its signature are of another one")
        at = datetime.fromisoformat(signature.findtext(f".//{XADES}SigningTime"))
        signed, _ = _signed(chain, at, trusted)
        results = XAdESVerifier().verify(
            root,
            x509_cert=x509.load_der_x509_certificate(chain[0]),
            expect_config=XAdESSignatureConfiguration(location="./"),
        )
    except Broken:
        raise
    except Exception as error:  # whatever the libraries make of damaged bytes
        raise Broken("its signature does not fit its bytes") from error
    if not any(each.signed_xml is not None and each.signed_xml.tag == root.tag for each in results):
        raise Broken("its signature is not over the whole document")
    return Signed(*signed)


def _decoded(text: str | None) -> bytes:
    """Base64 in the one way in which it is written here: other letters may mean the same bytes."""
    content = base64.b64decode("".join((text or "").split()), validate=True)
    if base64.b64encode(content).decode() != "".join((text or "").split()):
        raise ValueError("base64 is not written as it should be")
    return content


def _signed(
    certificates: Sequence[bytes], at: datetime, trusted: Sequence[bytes]
) -> tuple[tuple[str, datetime, str, str], bytes]:
    """What to say of the signer, the first of the certificates, and the root above it (DER).

    Every certificate up to one that issued itself is checked by the one above it.
    """
    chain = _chain([x509.load_der_x509_certificate(each) for each in certificates])
    for below, above in zip(chain, [*chain[1:], chain[-1]], strict=True):
        try:
            below.verify_directly_issued_by(above)
        except (InvalidSignature, ValueError, TypeError) as error:
            raise Broken(f"the certificate of {_name(below.subject)} does not hold") from error
        if not below.not_valid_before_utc <= at <= below.not_valid_after_utc:
            raise Broken(f"the certificate of {_name(below.subject)} was not valid on {at.date()}")
    root = chain[-1].public_bytes(Encoding.DER)
    if trusted and root not in trusted and certificates[0] not in trusted:
        raise Broken(f"{_name(chain[-1].subject)} is not the authority that you trust")
    authority = hashlib.sha256(root).hexdigest()
    return (_name(chain[0].subject), at, _name(chain[-1].subject), authority), root


def _chain(certificates: list[x509.Certificate]) -> list[x509.Certificate]:
    """The signer's certificate, then its issuers; all of them are in the file."""
    chain, others = certificates[:1], certificates[1:]
    while chain[-1].issuer != chain[-1].subject:
        above = next((each for each in others if each.subject == chain[-1].issuer), None)
        if above is None:
            raise Broken(f"the certificate of {_name(chain[-1].issuer)}, who vouches, is not in it")
        others.remove(above)
        chain.append(above)
    if others:
        raise Broken("its signature carries certificates that nothing stands under")
    return chain


def _check_contents(pdf: bytes, embedded: Any) -> None:
    """The signature's own bytes, which it cannot cover: written in one way, zeros behind.

    What it does not sign in itself (versions, the digests it announces, tags and lengths) is made
    again of what it does sign, of the certificates and of the signature proper.
    """
    of = embedded.signer_info
    parts = ("sid", "digest_algorithm", "signed_attrs", "signature_algorithm", "signature",
             "unsigned_attrs")  # fmt: skip
    signer = {name: of[name] for name in parts if of[name].native is not None}
    content = SignedData(
        {
            "version": "v1",
            "digest_algorithms": [of["digest_algorithm"]],
            "encap_content_info": {"content_type": "data"},
            "certificates": embedded.signed_data["certificates"],
            "signer_infos": [SignerInfo({"version": "v1", **signer})],
        }
    )
    made = ContentInfo({"content_type": "signed_data", "content": content}).dump()
    _, length, after, _ = (int(each) for each in embedded.byte_range)
    digits = pdf[length:after]
    if digits != f"<{made.hex().upper():0<{len(digits) - 2}}>".encode():
        raise Broken("the bytes of its signature are not written as they should be")


def _name(name: x509.Name) -> str:
    return name.rfc4514_string()
