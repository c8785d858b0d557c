"""Error limits of a laboratory's own equipment, from the certificates of its standards."""

from collections.abc import Iterable, Mapping

from schemas.equipment import EquipmentLimit, ErrorBound, LimitName, MeasurementStandard
from tasks.uncertainty.distributions import DIVISORS


def standard_uncertainty(bound: ErrorBound) -> float:
    """Half-width over the divisor of the distribution, in the bound's unit."""
    return bound.half_width / DIVISORS[bound.distribution]


def stated_limits(standards: Iterable[MeasurementStandard]) -> dict[LimitName, EquipmentLimit]:
    """What the certificates of the standards state, of two on one property the larger."""
    found: dict[LimitName, EquipmentLimit] = {}
    for standard in standards:
        for name, bound in standard.limits.items():
            limit = EquipmentLimit(**bound.model_dump(), source=source_of(standard))
            if name not in found or _is_larger(limit, found[name]):
                found[name] = limit
    return found


def own_limits(
    standards: Iterable[MeasurementStandard], own: Mapping[LimitName, EquipmentLimit]
) -> dict[LimitName, EquipmentLimit]:
    """The limits that the budgets take: what a laboratory states itself, else its standards."""
    return stated_limits(standards) | dict(own)


def source_of(standard: MeasurementStandard) -> str:
    """How a budget names the certificate of a standard."""
    return f"{standard.certificate} ({standard.serial})"


def _is_larger(one: ErrorBound, other: ErrorBound) -> bool:
    return standard_uncertainty(one) > standard_uncertainty(other)
