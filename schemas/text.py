"""Text for people in both languages, as `tasks.words` fills it: `Statement(**texts(message))`;
and the validity of a run, which remarks decide before the verdict on the unit."""

from typing import Literal, get_args

from schemas.base import Frozen

RunVerdict = Literal["valid", "remarks", "invalid"]
RUN_VERDICTS: tuple[RunVerdict, ...] = get_args(RunVerdict)  # the worst last


class Statement(Frozen):
    """A sentence or paragraph in both languages."""

    en: str
    zh: str


class Remark(Frozen):
    """Something the reader of a result must know, as a sentence in both languages.

    `blocks_pass`: a condition of the specification is not met, so no unit may pass. `run`: its
    consequence for the validity of the run.
    """

    code: str
    en: str
    zh: str
    segments: tuple[str, ...] = ()
    blocks_pass: bool = False
    run: RunVerdict = "valid"


class Validity(Frozen):
    """Whether a run can be relied on, and every reason why not.

    remarks: something is unknown, or not as the specification requires; the values stand, but no
    unit passes. invalid: no value of the run supports a verdict on the unit.
    """

    verdict: RunVerdict = "valid"
    reasons: tuple[str, ...] = ()
    reasons_zh: tuple[str, ...] = ()
