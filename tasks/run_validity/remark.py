"""The remark of a check."""

from collections.abc import Iterator
from difflib import get_close_matches
from itertools import chain

import numpy as np
from pydantic import BaseModel

from schemas.recording import Manifest, WrongCodes
from schemas.text import Remark, RunVerdict
from tasks.readings.codes import bug_in_words, size_in_words
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import Argument, message, remark
from tasks.words.numbers import plain


def run_remark(
    code: str,
    *segments: str,
    run: RunVerdict = "remarks",
    **arguments: Argument,
) -> Remark:
    """A remark on the run, or on some segments; its message is called `validity-` and its code.

    run: its consequence for the run; no unit passes on a run that is not valid.
    """
    sentence = message(f"validity-{code.replace('_', '-')}", **arguments)
    return remark(code, sentence, segments, blocks_pass=run != "valid", run=run)


# Fields of the manifest that nothing reads and that are spelled nearly like one that is absent.

SIMILAR_SPELLING = 0.85  # similarity of two spellings of one name, by difflib


def field_remarks(manifest: Manifest) -> Iterator[Remark]:
    """What others wrote into a manifest is kept, so that a misspelt field is taken for theirs.

    It may be theirs, and then no unit is to fail for it.
    """
    within = [("", manifest), ("unit.", manifest.unit), ("station.", manifest.station),
              ("mount.", manifest.mount)]  # fmt: skip
    segments = (("segments.", segment) for segment in manifest.segments or ())
    found = dict(chain.from_iterable(_misspelt(*each) for each in chain(within, segments)))
    for field, meant in found.items():
        yield run_remark("misspelt_field", run="valid", field=field, meant=meant)


def _misspelt(place: str, model: BaseModel) -> Iterator[tuple[str, str]]:
    # By value: a manifest in store has the defaults of fields that nobody wrote.
    absent = [
        name
        for name, field in type(model).model_fields.items()
        if not field.is_required() and getattr(model, name) == field.get_default()
    ]
    for name in model.model_extra or ():
        for meant in get_close_matches(name, absent, n=1, cutoff=SIMILAR_SPELLING):
            if not name.startswith(meant):  # rate_deg_s2 is another quantity
                yield place + name, place + meant


# Codes that firmware joined wrongly: what was put right of them, and what could not be.

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
