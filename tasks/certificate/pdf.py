"""The certificate as a PDF/A-3b file, set with typst."""

import json
from dataclasses import asdict
from datetime import UTC, datetime, time
from pathlib import Path
from typing import Any

from schemas.base import Unusable
from schemas.certificate import Certificate
from tasks.certificate.content import content
from tasks.certificate.fields import literal

TEMPLATE = Path(__file__).with_name("certificate.typ")


def render(certificate: Certificate) -> bytes:
    """The PDF of a certificate; the same certificate gives the same bytes.

    Raises Unusable where a text has a character that none of the fonts can show.
    """
    import pylopdf_fonts_zh_cn
    import typst

    said = _literal(asdict(content(certificate)))
    try:
        return typst.compile(
            TEMPLATE,
            format="pdf",
            font_paths=[pylopdf_fonts_zh_cn.serif_path().parent],
            ignore_system_fonts=True,
            sys_inputs={"certificate": json.dumps(said, ensure_ascii=False)},
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


def _literal(said: Any) -> Any:
    """Every text inside, without characters that have no glyph."""
    if isinstance(said, dict):
        return {key: _literal(value) for key, value in said.items()}
    if isinstance(said, list | tuple):
        return [_literal(value) for value in said]
    return literal(said) if isinstance(said, str) else said
