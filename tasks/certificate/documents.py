"""The three faces of a certificate: PDF, DCC and record, all made from the record; its evidence."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from schemas.certificate import Certificate
from tasks.certificate.dcc import dcc_of, record_of
from tasks.certificate.pdf import render

if TYPE_CHECKING:
    from tasks.certificate.sign import Signing

EVIDENCE, HEAD = b'"mimu-evidence/', 100  # bytes in which a file of that format names it


@dataclass(frozen=True)
class Faces:
    """The bytes of a certificate: the PDF/A-3b, the DCC (XML) and the record (JSON).

    evidence: the file beside them that the record names by its hash; None where there is none.
    """

    pdf: bytes
    dcc: bytes
    record: bytes
    evidence: bytes | None = None


def faces_of(
    certificate: Certificate, signing: "Signing | None", evidence: bytes | None = None
) -> Faces:
    """The faces of a certificate, signed where there is a key to sign with.

    The DCC holds the record, and the PDF, in the languages of the record, holds the DCC.
    """
    record, dcc = record_of(certificate), dcc_of(certificate)
    if signing is None:
        return Faces(render(certificate, dcc=dcc), dcc, record, evidence)
    # Late: pyHanko is a second and more, and few laboratories sign.
    from tasks.certificate.sign import sign_pdf
    from tasks.certificate.sign_xml import sign_xml

    dcc = sign_xml(dcc, signing)
    pdf = sign_pdf(render(certificate, dcc=dcc, signed=True), signing)
    return Faces(pdf, dcc, record, evidence)


def is_certificate(path: Path) -> bool:
    """Whether a file is one of a certificate, by its name; JSON by its format."""
    suffix = path.suffix.lower()
    if suffix == ".json" and path.is_file():
        content = path.read_bytes()
        return b"mimu-certificate-record/" in content or EVIDENCE in content[:HEAD]
    return suffix in (".pdf", ".xml")
