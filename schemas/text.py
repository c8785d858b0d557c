"""Text for people in both languages, as `tasks.words` fills it: `Statement(**texts(message))`."""

from schemas.base import Frozen
from schemas.validity import RunVerdict


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
