"""Checks of what a recording lacks: rows, triads, table readings."""

from collections.abc import Iterator

import numpy as np

from schemas.recording import MEASURED, TRIADS, Recording
from schemas.text import Remark
from tasks.motion.samples import covered
from tasks.segments.conditions import segment_remark
from tasks.segments.summarise import MIN_ROWS, SegmentMean, rows_of
from tasks.words import message


def completeness_remarks(
    recording: Recording, segments: tuple[SegmentMean, ...]
) -> Iterator[Remark]:
    """What is missing for some segments, or for the whole recording."""
    yield from _without_rows(recording)
    yield from _null_rows(recording)
    yield from _table_gap(recording, segments)


def _without_rows(recording: Recording) -> Iterator[Remark]:
    """Labelled segments that the recording has no rows of, or too few for a mean."""
    measured = [s for s in recording.manifest.segments or () if s.kind in MEASURED]
    counts = {s.name: rows_of(recording, s) for s in measured}
    empty = {name: rows for name, rows in counts.items() if rows < MIN_ROWS}
    if empty:
        listed = ", ".join(f"{name} {rows}" for name, rows in empty.items())
        yield segment_remark("without_rows", *empty, count=len(empty), listed=listed)


def _null_rows(recording: Recording) -> Iterator[Remark]:
    """Labelled segments that a triad of the unit has null rows in: it is not taken there."""
    imu = recording.imu
    measured = [s for s in recording.manifest.segments or () if s.kind in MEASURED]
    for triad in TRIADS:
        values = imu.columns.get(triad[0])
        if values is None or not np.isnan(values).any() or np.isnan(values).all():
            continue
        counts = {
            s.name: int(np.isnan(values[imu.rows(s.t_start, s.t_end)]).sum()) for s in measured
        }
        nulls = {name: count for name, count in counts.items() if count}
        if nulls:
            yield segment_remark(
                "null_rows", *nulls, blocks_pass=False,
                triad=triad[0].removesuffix("_x"), count=len(nulls),
                listed=", ".join(f"{segment} {count}" for segment, count in nulls.items()),
            )  # fmt: skip


def _table_gap(recording: Recording, segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Segments that the table stream, where there is one, does not cover."""
    table, imu = recording.table, recording.imu
    if table is None or not recording.manifest.station.table_axes:
        return
    rows = {s.segment.name: imu.rows(s.t_start, s.t_end) for s in segments}
    bare = {name: imu.t[row][~covered(table.t, imu.t[row])] for name, row in rows.items()}
    first = {name: float(t[0]) for name, t in bare.items() if len(t)}
    if first:
        gaps = tuple(
            message("segments-table-gap-from", segment=name, time=f"{t:.2f}")
            for name, t in first.items()
        )
        yield segment_remark("table_gap", *first, count=len(first), gaps=gaps)
