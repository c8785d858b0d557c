"""What a certificate by the clauses states, of the readings as they are and less what was found.

Imports nothing of the plant: the processes that explain write it, too.
"""

from typing import Any

from schemas.base import Unusable
from schemas.calibration import Calibration
from schemas.recording import Recording
from tasks.calibrate.calibrate import calibrate
from tasks.explain.correction.adopt import adopt
from tasks.explain.explanation import Explanation
from tasks.specifications.register import specification_for

CERTIFICATE = "certificate.json"
UNNAMED = "unnamed"
SCATTER = "excess_scatter"  # the remark of a residual beyond the noise, at 1 %


def certificate_of(recording: Recording) -> dict[str, Any] | None:
    """The clauses' items of a recording; None where it gives none.

    values: [value, U] by item and element. scatter: how many remarks say that residuals are
    beyond the noise, which is all that the clauses' own evaluation would notice.
    """
    try:
        return _stated(_by_clauses(recording))
    except Unusable:
        return None


def certificate_less(recording: Recording, explanation: Explanation) -> dict[str, Any] | None:
    """The same with what was found and named taken off first, as `calibrate --terms` does.

    What is unnamed cannot be ordered taken off, and stays. None where there is nothing to take
    off, or no item.
    """
    named = [finding for finding in explanation.findings if finding.effect != UNNAMED]
    if not named:
        return None
    try:
        return _stated(adopt(recording, named, _by_clauses, explanation.determined))
    except Unusable:
        return None


def _by_clauses(recording: Recording) -> Calibration:
    specification = specification_for(recording.manifest.standard)
    return calibrate(specification, recording, run="-", code_version="-")


def _stated(calibration: Calibration) -> dict[str, Any]:
    values = {
        f"{name} {element}": [value, item.U.get(element)]
        for name, item in calibration.items.items()
        for element, value in item.value.items()
        if value is not None and item.U.get(element)
    }
    return {"values": values, "scatter": sum(r.code == SCATTER for r in calibration.remarks)}
