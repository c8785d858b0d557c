"""A remark of a result, made of a message."""

from schemas.calibration import Remark
from tasks.words.catalogue import texts
from tasks.words.message import Sayable


def remark(
    code: str, text: Sayable, segments: tuple[str, ...] = (), *, blocks_pass: bool = False
) -> Remark:
    """A remark in every language; segments: names of those it is about."""
    return Remark(code=code, **texts(text), segments=segments, blocks_pass=blocks_pass)
