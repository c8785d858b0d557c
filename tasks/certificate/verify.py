"""Checks that the files of a certificate are intact and agree, without the store.

The PDF holds the DCC and the DCC holds the record, so that any of them can be checked where no
store is; a record or an evidence file alone is held against the PDF or the DCC that lies beside it.
"""

import base64
import hashlib
import io
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from lxml import etree
from pydantic import ValidationError
from pyhanko.pdf_utils.reader import PdfFileReader

from schemas.base import Unusable
from schemas.certificate import Certificate
from tasks.certificate.dcc import dcc_of
from tasks.certificate.dcc.document import RECORD
from tasks.certificate.dcc.quantities import DCC, SI, Element, canonical
from tasks.certificate.pdf import EVIDENCE, HEAD, render
from tasks.certificate.sign import DS, Broken, Signed, check_pdf_signature, check_xml_signature

UNSIGNED = (
    "nobody signed it, and its bytes are not those that this version of mimucal makes of its "
    "record; where another version made it, hold it against the catalogue"
)


@dataclass(frozen=True)
class VerifiedFile:
    """What a file of a certificate is, who signed it, and what is wrong with it.

    number, state, record_sha256: of the record that was found; None where none was.
    """

    path: Path
    number: str | None
    state: str | None
    record_sha256: str | None
    signatures: tuple[Signed, ...]
    faults: tuple[str, ...]


@dataclass(frozen=True)
class _Found:
    record: bytes
    certificate: Certificate
    signatures: tuple[Signed, ...]


def verify_file(path: Path, trusted: Sequence[bytes] = ()) -> VerifiedFile:
    """Everything that can be found out about a file of a certificate without the store.

    trusted: certificates (DER) of which one must stand above every signature; empty: any does.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise Unusable(f"{path} cannot be read ({error.strerror}); name another file.") from error
    check = {".pdf": _pdf, ".xml": _dcc}.get(path.suffix.lower())
    try:
        with warnings.catch_warnings(action="ignore"):  # of libraries, about damaged bytes
            found = check(content, trusted) if check else _beside(path, content, trusted)
    except Broken as fault:
        return VerifiedFile(path, None, None, None, (), (str(fault),))
    certificate = found.certificate
    digest = hashlib.sha256(found.record).hexdigest()
    return VerifiedFile(path, certificate.number, certificate.state, digest, found.signatures, ())


def _pdf(pdf: bytes, trusted: Sequence[bytes]) -> _Found:
    """The PDF, the DCC in it, and the record in that."""
    try:
        reader = PdfFileReader(io.BytesIO(pdf))
        embedded = list(reader.embedded_signatures)
        attached = [each.get_object() for each in reader.root["/AF"]]
        if len(embedded) > 1:
            raise Broken("it has several signatures")
        if len(attached) != 1:
            raise Broken("it has not one attachment, the DCC")
        signed = [check_pdf_signature(pdf, each, trusted) for each in embedded]
        dcc = attached[0]["/EF"]["/F"].data
    except Broken:
        raise
    except Exception as error:  # whatever a reader makes of damaged bytes
        raise Broken(f"it cannot be read as a PDF with a DCC ({error})") from error
    found = _dcc(dcc, trusted)
    if not signed and render(found.certificate, dcc=dcc) != pdf:
        raise Broken(UNSIGNED)
    if signed and [each.authority_sha256 for each in found.signatures] != [
        signed[0].authority_sha256
    ]:
        raise Broken("the attached DCC was not signed as the PDF was")
    return _Found(found.record, found.certificate, (*signed, *found.signatures))


def _dcc(dcc: bytes, trusted: Sequence[bytes]) -> _Found:
    """The DCC and the record in it: the same results in both."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=True)
    try:
        root = etree.fromstring(dcc, parser)
    except etree.XMLSyntaxError as error:
        raise Broken(f"the DCC cannot be read ({error})") from error
    if canonical(root) != dcc:
        raise Broken("the DCC is not written in its canonical form")
    signed = check_xml_signature(root, trusted)
    record = _attached_record(root)
    certificate = _certificate(record)
    for signature in root.findall(f"{DS}Signature"):
        root.remove(signature)
    made = dcc_of(certificate)
    if signed is None and made != dcc:
        raise Broken(f"of the DCC: {UNSIGNED}")
    if list(_results(root)) != list(_results(etree.fromstring(made))):
        raise Broken("the results of the DCC are not those of the record within it")
    return _Found(record, certificate, (signed,) if signed else ())


def _beside(path: Path, content: bytes, trusted: Sequence[bytes]) -> _Found:
    """A record or an evidence file, against the DCC or PDF beside it, which holds the record."""
    evidence = hashlib.sha256(content).hexdigest() if EVIDENCE in content[:HEAD] else None
    stem, what = path.name.removesuffix(".json"), "record"
    if evidence:
        stem, what = stem.removesuffix(".evidence"), "evidence"
    for suffix, check in ((".xml", _dcc), (".pdf", _pdf)):
        other = path.with_name(stem + suffix)
        if other.is_file():
            found = check(other.read_bytes(), trusted)
            same = (
                found.certificate.evidence_sha256 == evidence
                if evidence
                else found.record == content
            )
            if not same:
                raise Broken(
                    f"it is not the {what} that {other.name} {'names' if evidence else 'holds'}"
                )
            return found
    raise Broken(
        f"{what} alone vouches for nothing: put the PDF or the DCC of its certificate beside it"
    )


def _attached_record(root: Element) -> bytes:
    found = [
        each
        for statement in root.iter(f"{{{DCC}}}statement")
        if statement.get("refType") == RECORD
        for each in statement.iter(f"{{{DCC}}}dataBase64")
    ]
    if len(found) != 1:
        raise Broken("the DCC holds no record")
    try:
        return base64.b64decode(found[0].text or "", validate=True)
    except ValueError as error:
        raise Broken("the record in the DCC is not base64") from error


def _certificate(record: bytes) -> Certificate:
    try:
        return Certificate.model_validate_json(record)
    except ValidationError as error:
        raise Broken("the record in the DCC is no certificate record") from error


def _results(root: Element) -> Iterator[tuple[str | None, ...]]:
    """The number of the certificate, and every number with its unit, U and k."""
    yield (root.findtext(f".//{{{DCC}}}uniqueIdentifier"),)
    for real in root.iter(f"{{{SI}}}real"):
        names = ("label", "value", "unit", "valueExpandedMU", "coverageFactor")
        yield tuple(real.findtext(f".//{{{SI}}}{name}") for name in names)
