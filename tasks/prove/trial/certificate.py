"""What leaving the effects out does to the standard's own results, in their stated U."""

from typing import NamedTuple

from schemas.base import Unusable
from schemas.recording import Recording
from tasks.items.jjf2003 import calibrate


class Off(NamedTuple):
    """The value that is off most. ratio: |with effects − without| / U."""

    ratio: float
    item: str
    element: str


def certificate_off(recording: Recording, clean: Recording) -> Off | None:
    """JJF 2003-2022 by its clauses on a recording and on the same one, noise and all, without
    effects; None where it gives nothing."""
    try:
        shown, true = (calibrate(one, run="-", code_version="-") for one in (recording, clean))
    except Unusable:
        return None
    off = []
    for name, item in shown.items.items():
        beside = true.items[name].value if name in true.items else {}
        for element, value in item.value.items():
            known, U = beside.get(element), item.U[element]
            if value is not None and known is not None and U:
                off.append(Off(abs(value - known) / U, name, element))
    return max(off, default=None)
