"""Missing data: samples, rows, triads, table readings."""

from collections.abc import Iterator

import numpy as np

from schemas.recording import MEASURED, TRIADS, Recording, Stream
from schemas.text import Remark
from tasks.motion.polled import polled_within
from tasks.motion.samples import FARTHEST, covered, gaps
from tasks.readings.stamps import in_packets
from tasks.run_validity.remark import run_remark
from tasks.segments.one_pass import extreme_steps
from tasks.segments.summarise import CHANNELS, MIN_ROWS, SegmentMean, rows_of
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import message
from tasks.words.quantities import moment, plain

LARGEST_SHARE = 0.01  # of a segment's samples, or of the run's, that may be lost
GAP = 1.5  # sampling intervals: a longer step after which stamps stay late is a gap
POLLED_GAP = 5.0  # s: angles that are asked for one by one come as they can
BEYOND = 1.0  # s by which a segment may begin before the first sample, or end after the last


def lost_data_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """What is missing in some segments, or in the whole recording."""
    recording, segments = evidence.recording, evidence.segments
    for segment in segments:
        yield from _lost(recording, segment)
        yield from _beyond(recording, segment)
    yield from _share("imu", recording.imu, segments)
    if recording.table is not None and not polled_within(recording):
        yield from _share("table", recording.table, segments)
    yield from _without_rows(recording)
    yield from _null_rows(recording, segments)
    yield from _table_gap(recording, segments)


def _share(stream: str, rows: Stream, segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Samples of a stream that are missing in all segments together, by its sampling rate."""
    if len(rows) < 2 or not segments:
        return
    seconds = sum(s.segment.t_end - s.segment.t_start for s in segments)
    found = 0
    for s in segments:
        here = rows.rows(s.segment.t_start, s.segment.t_end)
        found += here.stop - here.start + 1  # one more for the ends
    if found >= (1.0 - LARGEST_SHARE) * seconds / extreme_steps(rows.t)[0]:
        return  # whatever the usual interval is
    packets = in_packets(rows.t)
    interval = float(np.median(np.diff(rows.t))) if packets is None else packets.interval
    share = 1.0 - found * interval / seconds
    if share > LARGEST_SHARE:
        yield run_remark(
            "lost_share", run="invalid", stream=stream, share=plain(100 * share, 2),
            limit=f"{100 * LARGEST_SHARE:g}",
        )  # fmt: skip


def _lost(recording: Recording, segment: SegmentMean) -> Iterator[Remark]:
    """Samples missing between two time stamps."""
    shortest, longest = segment.intervals
    if segment.rows < 3 or longest <= GAP * shortest:  # whatever the usual one is
        return
    t = recording.imu.t[segment.place]
    steps = np.diff(t)
    interval = float(np.median(steps))
    before = gaps(t, interval, GAP - 1.0)
    if not len(before):
        return
    lost = int(np.round(steps[before] / interval - 1).sum())
    worst = before[int(steps[before].argmax())]
    name, at = segment.segment.name, t[worst]
    yield run_remark(
        "lost_samples", name,
        run="invalid" if lost > LARGEST_SHARE * segment.rows else "valid",
        segment=name, lost=lost, gaps=len(before), longest=f"{steps[worst]:.3f}",
        time=f"{at:.2f}",
    )  # fmt: skip


def _beyond(recording: Recording, segment: SegmentMean) -> Iterator[Remark]:
    """A segment that reaches beyond the recording: wrong times, or samples that were cut off."""
    label, t = segment.segment, recording.imu.t
    if label.t_start < t[0] - BEYOND or label.t_end > t[-1] + BEYOND:
        yield run_remark(
            "beyond_recording", label.name, segment=label.name,
            start=moment(label.t_start), end=moment(label.t_end),
            first=moment(t[0]), last=moment(t[-1]),
        )  # fmt: skip


def _without_rows(recording: Recording) -> Iterator[Remark]:
    """Labelled segments that the recording has no rows of, or too few for a mean."""
    measured = [s for s in recording.manifest.segments or () if s.kind in MEASURED]
    counts = {s.name: rows_of(recording, s) for s in measured}
    empty = {name: rows for name, rows in counts.items() if rows < MIN_ROWS}
    if empty:
        listed = ", ".join(f"{name} {rows}" for name, rows in empty.items())
        yield run_remark("without_rows", *empty, count=len(empty), listed=listed)


def _null_rows(recording: Recording, segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Labelled segments in which a triad has null rows, and was not taken for them."""
    imu = recording.imu
    measured = [s for s in recording.manifest.segments or () if s.kind in MEASURED]
    for triad in TRIADS:
        values = imu.columns.get(triad[0])
        # The smallest is NaN where any is.
        if values is None or not np.isnan(values.min(initial=0.0)) or np.isnan(values).all():
            continue
        counts = {
            s.name: int(np.isnan(values[imu.rows(s.t_start, s.t_end)]).sum()) for s in measured
        }
        first = CHANNELS.index(triad[0])
        taken = {s.segment.name for s in segments if np.isfinite(s.mean[first])}
        nulls = {name: count for name, count in counts.items() if count and name not in taken}
        if nulls:
            yield run_remark(
                "null_rows", *nulls, run="valid",
                triad=triad[0].removesuffix("_x"), count=len(nulls),
                listed=", ".join(f"{segment} {count}" for segment, count in nulls.items()),
            )  # fmt: skip


def _table_gap(recording: Recording, segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Segments that the table stream, where there is one, does not cover."""
    table, imu = recording.table, recording.imu
    if table is None or not recording.manifest.station.table_axes:
        return
    farthest = POLLED_GAP if polled_within(recording) else FARTHEST
    bare = imu.t[~covered(table.t, imu.t, farthest=farthest)]
    first = {}
    for s in segments:
        start, stop = np.searchsorted(bare, (s.t_start, s.t_end))
        if stop > start:
            first[s.segment.name] = float(bare[start])
    if first:
        gaps = tuple(
            message("validity-table-gap-from", segment=name, time=f"{t:.2f}")
            for name, t in first.items()
        )
        yield run_remark("table_gap", *first, run="invalid", count=len(first), gaps=gaps)
