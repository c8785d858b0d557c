"""Made-up results of one item, and limits on them."""

from typing import Any

from schemas.calibration import Calibration, Item
from schemas.tolerance import Decision, Limit, Tolerance
from tasks.conformity import decide

BIAS = {"x": 0.01, "y": -0.02, "z": 0.03}


def item(value: dict[str, float | None], unit: str = "deg/s", **more: Any) -> Item:
    U = {element: None if v is None else 0.001 for element, v in value.items()}
    return Item(unit=unit, clause="7.2.2", value=value, u=U, U=U, **more)


def calibration(
    items: dict[str, Item], unavailable: dict[str, str] | None = None, **more: Any
) -> Calibration:
    return Calibration(
        recording_id="r", run="run1", digest="d", method="jjf2003", code_version="0",
        procedure="p", settings={}, items=items, unavailable=unavailable or {}, **more,
    )  # fmt: skip


def tolerance(*limits: Limit) -> Tolerance:
    return Tolerance(manufacturer="m", model="m", document="Q/1", limits=limits)


def bias_limit(**changes: Any) -> Limit:
    limit: dict[str, Any] = {"item": "gyro_bias", "unit": "deg/s", "lower": -0.05, "upper": 0.05}
    return Limit(**(limit | changes))


def with_uncertainty(value: float, U: float | None, **limit: Any) -> Decision:
    values: dict[str, float | None] = dict.fromkeys("xyz", value)
    uncertain = item(values).model_copy(update={"U": dict.fromkeys("xyz", U)})
    return decide(calibration({"gyro_bias": uncertain}), tolerance(bias_limit(**limit)))
