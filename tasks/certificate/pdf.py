"""The certificate as a PDF/A-3b file, set with typst, with the DCC attached."""

import hashlib
import io
import json
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime, time
from pathlib import Path

from schemas.base import Unusable
from schemas.certificate import Certificate
from tasks.certificate.content import content, in_languages
from tasks.certificate.dcc import dcc_of, record_of
from tasks.words import identifiers, message

TEMPLATE = Path(__file__).with_name("certificate.typ")
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
    Raises Unusable where a text has a character that none of the fonts can show.
    """
    import pylopdf_fonts_zh_cn
    import typst

    languages = languages or certificate.languages
    printed = {
        "languages": tuple(languages),
        "labels": {
            id_.removeprefix(LABEL): in_languages(message(id_, **PAGE), languages)
            for id_ in identifiers(LABEL)
        },
        **asdict(in_languages(content(certificate), languages)),
        "seal": _seal(certificate, languages, signed),
    }
    attached = dcc_of(certificate) if dcc is None else dcc
    try:
        return typst.compile(
            TEMPLATE,
            format="pdf",
            font_paths=[pylopdf_fonts_zh_cn.serif_path().parent],
            ignore_system_fonts=True,
            sys_inputs={
                "certificate": json.dumps(printed, ensure_ascii=False),
                "dcc": attached.decode(),
            },
            pdf_standards=["a-3b"],
            timestamp=datetime.combine(certificate.issued_on, time(), UTC),
        )
    except typst.TypstError as error:
        if "could not be displayed" not in error.message:
            raise
        character = error.message.split("`")[1]
        raise Unusable(
            f"Certificate {certificate.number} cannot be printed because no font shows the "
            f"text {character}: spell it otherwise in the manifest, laboratory or order file."
        ) from error


def sealed(number: str, record: bytes) -> str:
    """What the QR code holds: the number, and the SHA-256 of the record."""
    return f"{number} sha256:{hashlib.sha256(record).hexdigest()}"


def _seal(certificate: Certificate, languages: Sequence[str], signed: bool) -> dict[str, object]:
    """The QR code as SVG, what it holds, and the sentences beside it."""
    import segno

    text = sealed(certificate.number, record_of(certificate))
    svg = io.BytesIO()
    segno.make(text, error="m", micro=False).save(svg, kind="svg", border=4, xmldecl=False)
    how = message("certificate-seal.signed" if signed else "certificate-seal.by-hand")
    return {
        "code": svg.getvalue().decode(),
        "text": text,
        "sentences": in_languages((message("certificate-seal"), how), languages),
    }
