"""The verdict on a unit: its results against the limits of its product model (JCGM 106)."""

from tasks.conformity.capabilities import as_stated, check_capabilities
from tasks.conformity.decide import decide
from tasks.conformity.deviations import deviations
from tasks.conformity.equipment import (
    expired,
    failed_checks,
    is_traceable,
    is_virtual,
    smaller_than_stated,
    untraceable,
)
from tasks.conformity.reasons import Doubt

__all__ = [
    "Doubt",
    "as_stated",
    "check_capabilities",
    "decide",
    "deviations",
    "expired",
    "failed_checks",
    "is_traceable",
    "is_virtual",
    "smaller_than_stated",
    "untraceable",
]
