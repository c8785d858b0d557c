"""Limits as they are written in a file: relative ones, rules of their own, what is refused."""

from typing import Any

import pytest
from pydantic import ValidationError

from schemas.equipment import EquipmentLimit
from schemas.tolerance import Limit, Tolerance

LIMIT = {"item": "gyro_bias", "unit": "deg/s"}


def tolerance(limit: dict[str, Any], **file: Any) -> Tolerance:
    return Tolerance.model_validate(
        {"manufacturer": "m", "model": "m", "document": "d", "limits": [LIMIT | limit]} | file
    )


@pytest.mark.parametrize(
    ("written", "absolute"),
    [
        ({"nominal": 1.0, "magnitude": 0.01}, (0.99, 1.01)),
        ({"nominal": 3.2, "magnitude": 0.05}, (3.04, 3.36)),
        ({"nominal": -2.0, "lower": -0.1, "upper": 0.05}, (-2.2, -1.9)),
        ({"nominal": 200.0, "upper": 0.05}, (None, 210.0)),
        ({"nominal": 200.0, "lower": -0.05}, (190.0, None)),
    ],
)
def test_relative_limits_count_from_their_nominal(
    written: dict[str, Any], absolute: tuple[float | None, float | None]
) -> None:
    assert Limit(**LIMIT, relative=True, **written).bounds == absolute


@pytest.mark.parametrize(
    ("limit", "file", "names"),
    [
        ({"magnitude": 0.1, "relative": True}, {}, "nominal other than 0"),
        ({"magnitude": 0.1, "relative": True, "nominal": 0}, {}, "nominal other than 0"),
        ({"magnitude": 0.1, "nominal": 1}, {}, "not relative"),
        ({"magnitude": 1}, {"guard_band_factor": 1}, "no limit has the rule guard_band"),
        ({"magnitude": 1, "guard_band_factor": 1}, {}, "rule simple_acceptance"),
        ({"magnitude": 1}, {"rule": "shared_risk"}, "no bound on U is agreed"),
        ({"upper": 1}, {"rule": "shared_risk", "min_capability": 3}, "no bound on U is agreed"),
        ({"magnitude": 1, "U_max": 0}, {}, "U_max"),
        ({"magnitude": 1}, {"rule": "guard_band", "guard_band_factor": -1.01}, "guard_band_factor"),
        ({"magnitude": 1, "rule": "guard_band", "guard_band_factor": -1.2}, {}, "equal to -1"),
        ({"magnitude": 1, "prior": {"mean": 0, "sd": 0}}, {}, "sd"),
        ({"magnitude": 1, "rule": "guess"}, {}, "guess"),
    ],
)
def test_a_rule_that_is_not_complete_is_refused(
    limit: dict[str, Any], file: dict[str, Any], names: str
) -> None:
    with pytest.raises(ValidationError, match=names):
        tolerance(limit, **file)


@pytest.mark.parametrize("written", [True, "1"])
@pytest.mark.parametrize("field", ["magnitude", "lower", "U_max"])
def test_a_limit_is_a_number_and_nothing_that_looks_like_one(field: str, written: Any) -> None:
    with pytest.raises(ValidationError, match=field):
        tolerance({"upper": 3.0, field: written} if field != "magnitude" else {field: written})


@pytest.mark.parametrize("half_width", [True, "0.001", 1.5, 0.0, float("inf")])
def test_a_laboratory_limit_is_a_number_that_equipment_can_have(half_width: Any) -> None:
    limit = {"half_width": half_width, "distribution": "normal", "source": "paper"}
    with pytest.raises(ValidationError, match="half_width"):
        EquipmentLimit.model_validate(limit)
    assert EquipmentLimit.model_validate(limit | {"half_width": 1}).half_width == 1.0
