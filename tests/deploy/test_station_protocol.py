"""deploy/station.md and schemas/station.py say the same."""

from pathlib import Path

from deploy.station_protocol import frame_fields, text
from tasks.station.virtual.config import FRAMES

ROOT = Path(__file__).parents[2]


def test_the_document_is_what_the_schema_prints():
    written = (ROOT / "deploy" / "station.md").read_text(encoding="utf-8")
    assert written == text(), "run python -m deploy.station_protocol > deploy/station.md"


def test_the_documented_frame_is_the_frame_that_is_sent():
    for frame in FRAMES.values():
        assert "<" + "".join(code for code, _, _ in frame_fields(frame)) == frame.format
