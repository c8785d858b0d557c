"""The verdict on a unit: its results against the limits of its product model (JCGM 106)."""

from tasks.conformity.capabilities import (
    as_stated,
    check_capabilities,
    expired,
    failed_checks,
    is_traceable,
    is_virtual,
    smaller_than_stated,
    untraceable,
)
from tasks.conformity.decide import decide, deviations
from tasks.conformity.limits import Doubt

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
