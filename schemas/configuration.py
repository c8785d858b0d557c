"""The configuration of a unit during calibration, from its manifest or the client's order."""

from typing import Annotated

from pydantic import Field, ValidationError

from schemas.base import Frozen, Unusable, first_fault
from schemas.recording import Unit

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class Configuration(Frozen):
    """Ranges, output rate, bandwidth and firmware of a unit; null if unknown.

    rate_range_deg_s, accel_range_g: the largest input in either direction. condition: of the unit
    when it was received.
    """

    rate_range_deg_s: Positive | None = None
    accel_range_g: Positive | None = None
    output_rate_hz: Positive | None = None
    bandwidth_hz: Positive | None = None
    firmware: str | None = None
    condition: str | None = None
    condition_zh: str | None = None


def configuration_of(unit: Unit, ordered: Configuration | None) -> Configuration:
    """The configuration in the manifest's `unit`, completed by the order.

    Raises Unusable for an impossible value, and where the two contradict each other.
    """
    extra = unit.model_extra or {}
    named = {n: extra[n] for n in Configuration.model_fields if extra.get(n) is not None}
    try:
        recorded = Configuration.model_validate(named, strict=True).model_dump(exclude_none=True)
    except ValidationError as error:
        raise Unusable(
            f"the manifest's unit: {first_fault(error)}; correct it there and import the "
            "recording again"
        ) from error
    added = ordered.model_dump(exclude_none=True) if ordered else {}
    for name, value in added.items():
        if recorded.get(name, value) != value:
            raise Unusable(
                f"the order says configuration.{name} = {value}, but the manifest says "
                f"{recorded[name]}: correct the order"
            )
    return Configuration.model_validate(recorded | added)
