"""Checks a signature: whether it is valid, who made it and when; fetches nothing."""

import base64
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from asn1crypto.cms import ContentInfo, SignedData, SignerInfo
from asn1crypto.x509 import Certificate
from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives.serialization import Encoding
from pyhanko.sign.validation import validate_pdf_signature
from pyhanko.sign.validation.settings import KeyUsageConstraints
from pyhanko.sign.validation.status import SignatureCoverageLevel
from pyhanko_certvalidator import ValidationContext
from signxml.xades import XAdESSignatureConfiguration, XAdESVerifier

from tasks.certificate.dcc.xml import Element
from tasks.certificate.sign import DIGEST

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
