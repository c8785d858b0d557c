"""The validity of a run, which is decided before the verdict on the unit."""

from typing import Literal, get_args

from schemas.base import Frozen

RunVerdict = Literal["valid", "remarks", "invalid"]
RUN_VERDICTS: tuple[RunVerdict, ...] = get_args(RunVerdict)  # the worst last


class Validity(Frozen):
    """Whether a run can be relied on, and every reason why not.

    remarks: something is unknown, or not as the specification requires; the values stand, but no
    unit passes. invalid: no value of the run supports a verdict on the unit.
    """

    verdict: RunVerdict = "valid"
    reasons: tuple[str, ...] = ()
    reasons_zh: tuple[str, ...] = ()
