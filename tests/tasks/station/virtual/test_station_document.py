"""deploy/station.md and schemas/station.py say the same."""

import struct
from pathlib import Path

from schemas.station import FRAME_BYTES, FRAME_FORMAT
from tasks.station.virtual.document import FRAME_FIELDS, text

ROOT = Path(__file__).parents[4]


def test_the_document_is_what_the_schema_prints():
    written = (ROOT / "deploy" / "station.md").read_text(encoding="utf-8")
    assert written == text(), "run python -m tasks.station.virtual.document > deploy/station.md"


def test_the_documented_frame_is_the_frame_that_is_sent():
    assert "<" + "".join(code for code, _, _ in FRAME_FIELDS) == FRAME_FORMAT
    assert struct.calcsize(FRAME_FORMAT) == FRAME_BYTES
