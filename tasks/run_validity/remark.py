"""The remark of a check."""

from collections.abc import Sequence

from schemas.text import Remark
from schemas.validity import RunVerdict
from tasks.words import Argument, Message, message, remark

LISTED = 3  # segments that a sentence tells one by one


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


def first_of(entries: Sequence[str | Message]) -> Message:
    """What is said of some segments, one after the other; of many, the first and how many more."""
    listed = message("validity-listed", entries=tuple(entries[:LISTED]))
    more = len(entries) - LISTED
    return message("validity-first-of", listed=listed, more=more) if more > 0 else listed
