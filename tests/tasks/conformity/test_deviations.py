"""Conditions that were not met, or not checked: deviations that prevent a pass unless waived."""

from typing import Any

import pytest
from sample_results import calibration

from schemas.base import Unusable
from schemas.calibration import Calibration, SegmentUsed
from schemas.certificate import ConditionName
from schemas.configuration import Configuration, configuration_of
from schemas.recording import AXES, Unit
from schemas.text import Remark
from tasks.conformity import deviations

WAIVED: tuple[ConditionName, ...] = ("largest_rate", "environment")


def turned(to: float, axes: tuple[str, ...] = AXES, **more: Any) -> Calibration:
    segments = [
        {"name": axis, "kind": "rate", "t_start": 0, "t_end": 30, "origin": "label", "axis": axis,
         "rate_deg_s": to, "rows": 9}
        for axis in axes
    ]  # fmt: skip
    return calibration({}).model_copy(
        update={"segments": tuple(map(SegmentUsed.model_validate, segments))} | more
    )


def names(result: Calibration, largest: float | None) -> list[str]:
    return [each.name for each in deviations(result, Configuration(rate_range_deg_s=largest))]


def test_the_largest_rate_of_the_units_range_has_to_be_included_about_every_axis() -> None:
    assert names(turned(-500.0), 500.0) == []
    assert names(turned(300.0), 500.0) == ["largest_rate"]
    assert names(turned(500.0, ("x", "y")), 500.0) == ["largest_rate"]


def test_a_range_that_nobody_states_was_not_checked() -> None:
    assert names(turned(500.0), None) == ["largest_rate"]


def test_a_unit_that_was_not_turned_has_no_largest_rate_to_check() -> None:
    assert names(calibration({}), None) == []


def test_jjf_1536_asks_for_rates_within_the_range_and_not_for_the_largest() -> None:
    assert names(turned(100.0, method="jjf1536"), 500.0) == []


def test_air_that_was_not_recorded_is_a_condition_that_was_not_checked() -> None:
    remark = Remark(code="environment_not_recorded", en="Air.", zh="Air.")
    assert names(turned(500.0, remarks=(remark,)), 500.0) == ["environment"]


@pytest.mark.parametrize("waived", [(), WAIVED])
def test_what_the_order_waives_is_still_told(waived: tuple[ConditionName, ...]) -> None:
    (each,) = deviations(turned(300.0), Configuration(rate_range_deg_s=500.0), waived)
    assert each.waived == bool(waived)
    assert each.printed.id == f"conformity-deviation.{'waived' if waived else 'open'}"


def test_the_order_adds_to_the_manifest_and_may_not_contradict_it() -> None:
    unit = Unit.model_validate(
        {"manufacturer": "M", "model": "U", "serial": "1", "rate_range_deg_s": 500}
    )
    both = configuration_of(unit, Configuration(firmware="2.1", rate_range_deg_s=500.0))
    assert (both.rate_range_deg_s, both.firmware) == (500.0, "2.1")
    with pytest.raises(Unusable, match=r"order says configuration.rate_range_deg_s = 300.*500"):
        configuration_of(unit, Configuration(rate_range_deg_s=300.0))
    bad = unit.model_copy(update={"rate_range_deg_s": "fast"})
    with pytest.raises(Unusable, match=r"rate_range_deg_s.*correct it there"):
        configuration_of(bad, None)
