"""The specification's requirements on every point: its duration, and that it is distinct."""

from collections.abc import Iterator
from itertools import pairwise

from schemas.text import Remark
from tasks.run_validity.remark import run_remark
from tasks.segments.conditions import Conditions
from tasks.segments.summarise import SegmentMean
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import message

LISTED_PAIRS = 5


def point_remarks(evidence: ClauseEvidence, conditions: Conditions) -> Iterator[Remark]:
    """Points that are too short, and points that share their samples."""
    yield from _short(evidence.segments, conditions)
    yield from _overlapping(evidence.segments)


def _short(segments: tuple[SegmentMean, ...], conditions: Conditions) -> Iterator[Remark]:
    """Every segment that lasts less than each point must last."""
    held = [segment for segment in segments if segment.segment.kind != "rotation"]
    short = {s.segment.name: _lasts(s) for s in held if _lasts(s) < conditions.dwell_s - 1e-6}
    if short:
        yield run_remark(
            "short_dwell", *short, short=len(short), held=len(held),
            asked=f"{conditions.dwell_s:.0f}", clause=conditions.dwell_clause,
            listed=", ".join(f"{name} {lasts:.1f} s" for name, lasts in short.items()),
        )  # fmt: skip


def _lasts(segment: SegmentMean) -> float:
    """How long a segment lasts (s): its samples, and up to two intervals that its label adds."""
    interval = segment.seconds / segment.rows
    asked = segment.segment.t_end - segment.segment.t_start
    return max(segment.seconds, min(asked, segment.seconds + 2 * interval))


def _overlapping(segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Segments that share more than one row: the same noise would be counted as new evidence."""
    ordered = sorted(segments, key=lambda s: s.t_start)
    pairs = [
        (first.segment.name, second.segment.name)
        for first, second in pairwise(ordered)
        if second.t_start < first.t_end - 1.5 * first.seconds / first.rows
    ]
    if pairs:
        listed = [message("validity-pair", first=a, second=b) for a, b in pairs[:LISTED_PAIRS]]
        names = dict.fromkeys(name for pair in pairs for name in pair)
        yield run_remark(
            "overlapping_segments", *names,
            pairs=tuple(listed), more=max(len(pairs) - LISTED_PAIRS, 0),
        )  # fmt: skip
