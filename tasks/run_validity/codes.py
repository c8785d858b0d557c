"""Codes that firmware joined wrongly: what was put right of them, and what could not be."""

from collections.abc import Iterator

import numpy as np

from schemas.recording import WrongCodes
from schemas.text import Remark
from tasks.readings.codes import bug_in_words, size_in_words
from tasks.run_validity.remark import run_remark
from tasks.specifications.evidence import ClauseEvidence
from tasks.words.quantities import plain

MOST_UNDECIDED = 0.01  # of a segment's readings of one channel: so few weigh little
EXPECTED = (
    "stuck-high",
    "stuck-low",
)  # an expectation is put in their place


def code_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """One remark for each bug, with the channels that have it."""
    every = evidence.recording.wrong_codes
    for bug, codes in dict.fromkeys((one.bug, one.codes) for one in every):
        alike = [one for one in every if (one.bug, one.codes) == (bug, codes)]
        undecided = {name: None for one in alike for name in _undecided(one, evidence)}
        lost = bool(undecided) or bug in EXPECTED
        yield run_remark(
            "codes_undecided" if lost else "codes_put_right", *undecided,
            run="invalid" if lost else "remarks", bug=bug_in_words(alike[0]),
            channels=tuple(one.channel for one in alike), size=size_in_words(alike[0]),
            share=plain(100.0 * max(one.share for one in alike), 2), segments=len(undecided),
        )  # fmt: skip


def _undecided(wrong: WrongCodes, evidence: ClauseEvidence) -> Iterator[str]:
    """The segments in which too many readings could not be put right."""
    for segment in evidence.segments:
        if np.mean(wrong.undecided[segment.place]) > MOST_UNDECIDED:
            yield segment.segment.name
