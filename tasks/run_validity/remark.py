"""The remark of a check."""

from schemas.text import Remark, RunVerdict
from tasks.words import Argument, message, remark


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
