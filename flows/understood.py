"""Prints what was understood of a logger's table."""

from typing import Any

from flows.terminal import print_rows
from schemas.recording import Segment
from tasks.stages.logger_table import LogShown, shown_of
from tasks.words import say


def print_understood(shown: LogShown) -> None:
    """Columns and units, segments with what the readings show, notes, doubts, and the picture."""
    recording = shown.understood.recording
    imu = recording.imu
    print_rows(
        "Columns",
        ("channel", "column", "unit", "known by"),
        [(row.channel, row.column, row.unit, row.how) for row in shown.understood.rows],
    )
    seconds = float(imu.t[-1] - imu.t[0])
    rate = (len(imu) - 1) / seconds if seconds else 0.0
    print(f"{len(imu)} rows over {seconds:.3f} s, {rate:.6g} Hz")
    if shown.segments:
        title = "Segments found (rates proposed)" if shown.proposed else "Segments"
        print_rows(
            title,
            ("segment", "from, s", "to, s", "what", "the readings show"),
            [
                (s.name, f"{s.t_start:.2f}", f"{s.t_end:.2f}", _what(s), shown_of(recording, s))
                for s in shown.segments
            ],
        )
    else:
        print("no segments: nothing can be estimated; give a protocol")
    for note in shown.notes:
        print(f"· {note}")
    for doubt in shown.doubts:
        print(f"! {say(doubt)}")
    print(f"picture: {shown.picture}")


def understood_document(shown: LogShown) -> dict[str, Any]:
    """The same as a part of the command's JSON."""
    recording = shown.understood.recording
    return {
        "rows": len(recording.imu),
        "seconds": float(recording.imu.t[-1] - recording.imu.t[0]),
        "gravity_m_s2": shown.understood.gravity,
        "columns": {
            row.channel: {"column": row.column, "unit": row.unit, "known_by": row.how}
            for row in shown.understood.rows
        },
        "segments": [s.model_dump(mode="json", exclude_none=True) for s in shown.segments],
        "segments_found": shown.proposed,
        "notes": list(shown.notes),
        "doubts": [say(doubt) for doubt in shown.doubts],
        "picture": str(shown.picture),
    }


def _what(segment: Segment) -> str:
    if segment.kind == "static":
        turned = "" if segment.turn_deg is None else f", turned {segment.turn_deg:g}°"
        return f"rest, {segment.up or 'aslant'} up{turned}"
    if segment.kind == "rate":
        return f"{segment.rate_deg_s:+g} deg/s about {segment.axis}"
    return f"{segment.angle_deg:+g}° about {segment.axis}"
