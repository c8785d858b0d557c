"""7.2.1 and 7.3.1: ten readings a second or more."""

from collections.abc import Iterator

from schemas.text import Remark
from tasks.specifications.jjf1536.evidence import AhrsEvidence, is_zero_position
from tasks.words import message, remark

SLOWEST_SAMPLING = 10.0  # Hz
LOST = 0.5  # Hz: fewer were lost, not sampled more slowly


def sampling_remarks(evidence: AhrsEvidence) -> Iterator[Remark]:
    """Rests and turns that were sampled more slowly."""
    slow = {
        segment.segment.name: segment.rows / segment.seconds
        for i, segment in enumerate(evidence.segments)
        if (is_zero_position(segment) or any(i in turns for turns in evidence.turns.values()))
        and segment.rows / segment.seconds < SLOWEST_SAMPLING - LOST
    }
    if slow:
        text = message(
            "jjf1536-slow-sampling", count=len(slow), rate=f"{min(slow.values()):.3g}",
            asked=f"{SLOWEST_SAMPLING:.0f}",
        )  # fmt: skip
        yield remark("slow_sampling", text, tuple(slow), blocks_pass=True)
