"""The laboratory's signature in the DCC: XAdES B-B, enveloped (XMLDSig, ETSI EN 319 132)."""

import asyncio
from typing import Any

from cryptography import x509
from lxml import etree
from signxml import DigestAlgorithm, SignatureMethod, methods
from signxml.xades import XAdESDataObjectFormat, XAdESSigner

from tasks.certificate.dcc.xml import canonical
from tasks.certificate.sign import DIGEST, Signing


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
