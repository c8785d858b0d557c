"""The certificate as a PDF/A-3b file, set with typst, with the DCC attached."""

import hashlib
import io
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime, time
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pylopdf_fonts_zh_cn
import segno
import typst

from schemas.base import Unusable
from schemas.certificate import Certificate, Laboratory
from schemas.text import Appearance
from tasks.certificate.content import content, in_languages
from tasks.certificate.dcc import dcc_of, record_bytes
from tasks.certificate.figures import drawn
from tasks.words import MAIN, identifiers, message, say, statement

if TYPE_CHECKING:
    from tasks.certificate.sign import Signing


LAYOUT = {path.name: path.read_bytes() for path in Path(__file__).parent.glob("*.typ")}
HOUSE, ENTRY = "certificate.typ", "main.typ"  # ENTRY: what the typesetter begins with
LABEL = "certificate-label-"
PAGE = {"here": "<here>", "last": "<last>"}  # known to the typesetter alone


def render(
    certificate: Certificate,
    languages: Sequence[str] | None = None,
    dcc: bytes | None = None,
    signed: bool = False,
) -> bytes:
    """The PDF of a certificate; the same certificate gives the same bytes.

    languages: one or several, each with a catalogue, the first set large; those of the record
    where none are given. dcc: what is
    attached, unless it is the DCC without a signature. signed: whether the PDF is going to be,
    so that nobody signs it by hand.
    Raises Unusable where a text has a character that none of the fonts can show, and where the
    laboratory's template or pictures cannot be set.
    """
    languages = languages or certificate.languages
    laboratory = certificate.laboratory
    appearance = (laboratory and laboratory.appearance) or Appearance()
    printed = {
        "languages": tuple(languages),
        "script": say(message("typography-script"), languages[0]),
        "region": say(message("typography-script.region"), languages[0]),
        "labels": _labels(certificate.laboratory, languages),
        "pictures": tuple(appearance.pictures),
        **asdict(in_languages(content(certificate), languages)),
        "drawn": drawn(certificate),
        "seal": _qr_code(certificate, languages, signed),
    }
    main = appearance.template.encode() if appearance.template else LAYOUT[HOUSE]
    attached = dcc_of(certificate) if dcc is None else dcc
    try:
        return typst.compile(
            {**LAYOUT, ENTRY: main, **appearance.pictures},
            root=Path(__file__).parent,
            format="pdf",
            font_paths=_fonts(),
            sys_inputs={
                "certificate": json.dumps(printed, ensure_ascii=False),
                "dcc": attached.decode(),
            },
            pdf_standards=["a-3b"],
            timestamp=datetime.combine(certificate.issued_on, time(), UTC),
        )
    except typst.TypstError as error:
        if "could not be displayed" not in error.message:
            raise _unset(error.message, appearance) from error
        character = error.message.split("`")[1]
        raise Unusable(
            f"Certificate {certificate.number} cannot be printed because no font shows the "
            f"text {character}: spell it differently in the manifest, laboratory or order file."
        ) from error


@cache
def _fonts() -> Any:
    """The typesetter's fonts, read once: none of the system's, which differ by machine."""
    folder = pylopdf_fonts_zh_cn.serif_path().parent
    return typst.Fonts(include_system_fonts=False, font_paths=[folder])


def _unset(fault: str, appearance: Appearance) -> Exception:
    """What says that the laboratory's files cannot be set; of the house's own layout, a fault."""
    own = [*appearance.pictures, *(["template"] if appearance.template else [])]
    if not own:
        return RuntimeError(f"the certificate's layout cannot be set: {fault}")
    return Unusable(
        f"No certificate was made: it cannot be typeset with the {' and '.join(own)} of "
        f"laboratory.toml ({fault}); correct the file, or remove it from laboratory.toml."
    )


def _labels(laboratory: Laboratory | None, languages: Sequence[str]) -> dict[str, object]:
    """The labels of the layout, by the laboratory's own wording where it has one."""
    own = laboratory.wording if laboratory else {}
    names = [id_.removeprefix(LABEL) for id_ in identifiers(LABEL)]
    if unknown := sorted(own.keys() - set(names)):
        raise Unusable(
            f"laboratory.toml: wording names {unknown[0]!r}, which no certificate has; the names "
            f"are those of `certificate-label-…` in tasks/words/{MAIN}/certificate.ftl."
        )
    return {
        name: in_languages(
            statement(own[name]) if name in own else message(f"{LABEL}{name}", **PAGE), languages
        )
        for name in names
    }


def sealed(number: str, record: bytes) -> str:
    """What the QR code holds: the number, and the SHA-256 of the record."""
    return f"{number} sha256:{hashlib.sha256(record).hexdigest()}"


def _qr_code(certificate: Certificate, languages: Sequence[str], signed: bool) -> dict[str, object]:
    """The QR code as SVG, what it holds, and the sentences beside it."""
    text = sealed(certificate.number, record_bytes(certificate))
    svg = io.BytesIO()
    segno.make(text, error="m", micro=False).save(svg, kind="svg", border=4, xmldecl=False)
    how = message("certificate-seal.signed" if signed else "certificate-seal.by-hand")
    return {
        "code": svg.getvalue().decode(),
        "text": text,
        "sentences": in_languages((message("certificate-seal"), how), languages),
    }


# The three faces of a certificate: PDF, DCC and record, all made from the record; its evidence.

EVIDENCE, HEAD = b'"mimu-evidence/', 100  # bytes in which a file of that format names it


@dataclass(frozen=True)
class CertificateFiles:
    """The bytes of a certificate: the PDF/A-3b, the DCC (XML) and the record (JSON).

    evidence: the file beside them that the record names by its hash; None where there is none.
    """

    pdf: bytes
    dcc: bytes
    record: bytes
    evidence: bytes | None = None


def faces_of(
    certificate: Certificate, signing: "Signing | None", evidence: bytes | None = None
) -> CertificateFiles:
    """The faces of a certificate, signed where there is a key to sign with.

    The DCC holds the record, and the PDF, in the languages of the record, holds the DCC.
    """
    record, dcc = record_bytes(certificate), dcc_of(certificate)
    if signing is None:
        return CertificateFiles(render(certificate, dcc=dcc), dcc, record, evidence)
    # Late: pyHanko is a second and more, and few laboratories sign.
    from tasks.certificate.sign import sign_pdf, sign_xml

    dcc = sign_xml(dcc, signing)
    pdf = sign_pdf(render(certificate, dcc=dcc, signed=True), signing)
    return CertificateFiles(pdf, dcc, record, evidence)


def is_certificate(path: Path) -> bool:
    """Whether a file is one of a certificate, by its name; JSON by its format."""
    suffix = path.suffix.lower()
    if suffix == ".json" and path.is_file():
        content = path.read_bytes()
        return b"mimu-certificate-record/" in content or EVIDENCE in content[:HEAD]
    return suffix in (".pdf", ".xml")
