"""Errors that a certificate states as a function: what is no such table is refused by its row."""

import math
from typing import Any

import pytest
from pydantic import ValidationError

from schemas.base import first_fault
from schemas.equipment import MeasurementStandard

ROWS = [{"at": 10.0, "deviation": 1e-5, "U": 1e-5}, {"at": 50.0, "deviation": 1e-5, "U": 1e-5}]
STANDARD = {"name": "T", "name_zh": "台", "serial": "1", "accuracy": "", "certificate": "C"}
CALIBRATED = {"calibrated_on": "2026-01-01"}
DRIFT = {"per_year": 1e-6, "distribution": "normal"}
POLYNOMIAL = {"coefficients": [1e-5], "lowest": 1.0, "highest": 2.0, "U": 1e-5}


def fault(name: str, **function: Any) -> str:
    more = function.pop("standard", {})
    with pytest.raises(ValidationError) as refused:
        MeasurementStandard.model_validate(
            STANDARD | {"functions": {name: {"deviation": "corrected"} | function}} | more
        )
    return first_fault(refused.value)


def test_a_table_is_taken_for_rate_and_position_and_one_row_for_gravity_and_time() -> None:
    one = {"deviation": "budgeted", "rows": [{"deviation": 0.0, "U": 1e-5}]}
    table = {"deviation": "corrected", "rows": ROWS, "drift": DRIFT}
    made = MeasurementStandard.model_validate(
        STANDARD
        | CALIBRATED
        | {"functions": {"rate": table, "position": table, "gravity": one, "time_base": one}}
    )
    assert MeasurementStandard.model_validate_json(made.model_dump_json()) == made


@pytest.mark.parametrize(
    ("function", "sentence"),
    [
        ({"rows": []}, "either rows or polynomials"),
        ({"rows": ROWS, "polynomials": [POLYNOMIAL]}, "either rows or polynomials"),
        ({"rows": [*ROWS, ROWS[0]]}, "row at = 10 follows at = 50: sort the rows"),
        ({"rows": [ROWS[0], ROWS[0]]}, "row at = 10 follows at = 10: sort the rows"),
        ({"rows": [ROWS[0] | {"at": math.nan}]}, "rows.0.at: Input should be a finite number"),
        ({"rows": [ROWS[0] | {"deviation": math.nan}]}, "rows.0.deviation"),
        ({"rows": [ROWS[0] | {"U": 0.0}]}, "rows.0.U: Input should be greater than 0"),
        ({"rows": [ROWS[0] | {"at": -5.0}]}, "rates are stated without a sign"),
        ({"rows": [{"deviation": 0.0, "U": 1e-5}]}, "a row needs `at`, the rate"),
        ({"rows": [ROWS[0] | {"axis": "inner"}, ROWS[1]]}, "name one in each, or none"),
        ({"polynomials": [POLYNOMIAL, POLYNOMIAL]}, "two polynomials of axis (every)"),
        ({"polynomials": [POLYNOMIAL | {"highest": 1.0}]}, "lowest = 1 is not below highest = 1"),
        ({"polynomials": [POLYNOMIAL | {"coefficients": [0, 1]}]}, "reaches 2 between 1 and 2"),
        ({"rows": ROWS, "drift": DRIFT}, "functions.rate.drift counts from calibrated_on"),
        ({"rows": ROWS, "standard": {"limits": {"rate": {"half_width": 1e-5,
          "distribution": "normal"}}}}, "rate stands in limits and in functions"),
    ],
)  # fmt: skip
def test_what_is_no_function_of_the_rate_is_refused(
    function: dict[str, Any], sentence: str
) -> None:
    assert sentence in fault("rate", **function)


def test_what_has_no_function_is_refused() -> None:
    assert "state fixture in limits" in fault("fixture", rows=ROWS)
    assert "functions.gravity has one value" in fault("gravity", rows=ROWS)
    assert "functions.time_base has one value" in fault("time_base", polynomials=[POLYNOMIAL])
