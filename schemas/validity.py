"""The validity of a run, which is decided before the verdict on the unit."""

from typing import Literal, get_args

from schemas.base import Frozen

RunVerdict = Literal["valid", "remarks", "invalid"]
RUN_VERDICTS: tuple[RunVerdict, ...] = get_args(RunVerdict)  # the worst last


class Validity(Frozen):
    """Whether a run can be relied on, and every reason why not.

    remarks: something is not known, or not as the specification asks; the values stand, no unit
    passes on them. invalid: no value of the run bears a verdict on the unit.
    """

    verdict: RunVerdict = "valid"
    reasons: tuple[str, ...] = ()
    reasons_zh: tuple[str, ...] = ()
