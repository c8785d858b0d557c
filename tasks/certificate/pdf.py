"""The certificate as a PDF/A-3b file, set with typst."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime, time
from pathlib import Path

from schemas.base import Unusable
from schemas.certificate import Certificate
from tasks.certificate.content import content, in_languages
from tasks.words import identifiers, message

TEMPLATE = Path(__file__).with_name("certificate.typ")
LANGUAGES = ("zh", "en")  # the large one first
LABEL = "certificate-label-"
PAGE = {"here": "<here>", "last": "<last>"}  # known to the typesetter alone


def render(certificate: Certificate, languages: Sequence[str] = LANGUAGES) -> bytes:
    """The PDF of a certificate; the same certificate gives the same bytes.

    languages: one or several, each with a catalogue; the first is set large.
    Raises Unusable where a text has a character that none of the fonts can show.
    """
    import pylopdf_fonts_zh_cn
    import typst

    printed = {
        "languages": tuple(languages),
        "labels": {
            id_.removeprefix(LABEL): in_languages(message(id_, **PAGE), languages)
            for id_ in identifiers(LABEL)
        },
        **asdict(in_languages(content(certificate), languages)),
    }
    try:
        return typst.compile(
            TEMPLATE,
            format="pdf",
            font_paths=[pylopdf_fonts_zh_cn.serif_path().parent],
            ignore_system_fonts=True,
            sys_inputs={"certificate": json.dumps(printed, ensure_ascii=False)},
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
