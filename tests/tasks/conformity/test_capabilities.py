"""No U below the laboratory's capability is decided on; the result keeps its own."""

from collections.abc import Mapping
from datetime import date
from typing import Any

import pytest
from pydantic import ValidationError

from schemas.base import Unusable
from schemas.calibration import Calibration, SegmentUsed
from schemas.certificate import Laboratory, Party
from schemas.laboratory import EquipmentLimit, ErrorBound, LimitName, MeasurementStandard
from schemas.tolerance import Capability
from tasks.conformity import (
    as_stated,
    check_capabilities,
    decide,
    failed_checks,
    smaller_than_stated,
)
from tasks.uncertainty.budget import Contribution, combine, observed
from tasks.uncertainty.equipment import (
    JJF1536,
    JJF2003,
    Equipment,
    with_limits,
)
from tasks.uncertainty.monte_carlo import combine_as_example
from tasks.words import say
from tests.own_limits import SOURCE, as_table_1
from tests.tasks.conformity.sample_results import BIAS, bias_limit, calibration, item, tolerance

# What the measuring equipment says against a pass: limits that nobody stated, and other ones.

OWN = as_table_1()
DAY = date(2026, 9, 1)  # of the measurement


def made_with(equipment: Equipment, name: str = "gyro_bias") -> Calibration:
    """A made-up result whose budgets hold the table's rate and the fixture."""
    lines = [observed(1e-4, "deg/s")]
    lines += [Contribution(limit.quantity, 1.0) for limit in equipment.rate_at(1.0)]
    assert equipment.fixture is not None
    lines.append(Contribution(equipment.fixture.quantity, 1.0))
    budgets = {e: combine(f"{name}.{e}", "deg/s", value, lines) for e, value in BIAS.items()}
    return calibration({name: item(dict(BIAS), budgets=budgets)})


def own(limits: Mapping[LimitName, EquipmentLimit] = OWN) -> Equipment:
    return with_limits(JJF2003, limits)


def table(**half_widths: float) -> MeasurementStandard:
    bounds = {
        name: ErrorBound(half_width=half_width, distribution="rectangular")
        for name, half_width in half_widths.items()
    }
    return MeasurementStandard.model_validate(
        {"name": "Table", "name_zh": "转台", "serial": "T-1", "accuracy": "",
         "certificate": "C-9", "limits": bounds}
    )  # fmt: skip


@pytest.mark.parametrize("equipment", [JJF2003, JJF1536], ids=["2003", "1536"])
def test_limits_that_equipment_is_taken_to_meet_give_no_pass(equipment):
    decision = decide(made_with(equipment), tolerance(bias_limit()))
    assert decision.verdict == "inconclusive"
    (reason,), (reason_zh,) = decision.reasons, decision.reasons_zh
    assert "Table 1" in reason
    assert "table rate" in reason
    assert "squareness of fixture" in reason
    assert "a pass requires those of the laboratory's own equipment" in reason
    assert "夹具" in reason_zh


def test_limits_of_the_laboratory_own_equipment_pass():
    decision = decide(made_with(own()), tolerance(bias_limit()))
    assert (decision.verdict, decision.reasons) == ("pass", ())


def test_one_limit_that_is_still_the_specifications_gives_no_pass():
    stated = {name: limit for name, limit in OWN.items() if name != "fixture"}
    (reason,) = decide(made_with(own(stated)), tolerance(bias_limit())).reasons
    assert "squareness of fixture" in reason
    assert "table rate" not in reason


def test_an_item_without_a_limit_does_not_need_own_limits():
    limited = made_with(own())
    other = made_with(JJF2003, "gyro_fit_offset")
    both = limited.model_copy(update={"items": {**limited.items, **other.items}})
    assert decide(both, tolerance(bias_limit())).verdict == "pass"


def test_the_table_of_the_appendix_gives_no_pass_either():
    budgets = {e: combine_as_example(f"gyro_bias.{e}", "1", 0.0, [1e-4]) for e in BIAS}
    example = calibration({"gyro_bias": item(dict(BIAS), budgets=budgets)})
    (reason,) = decide(example, tolerance(bias_limit())).reasons
    assert "Appendix A" in reason


def test_a_budget_with_less_than_the_equipment_list_states_gives_no_pass():
    """A list with a rate accuracy of 1e-4 beside a budget with 1e-5."""
    result = made_with(own())
    (reason,) = smaller_than_stated(result, [table(rate=1e-4)], DAY)
    assert say(reason, "en") == (
        f"table rate over whole turns: the budget uses ±1×10⁻⁵ (rectangular; {SOURCE}), less than "
        "the ±0.0001 (rectangular) stated for the equipment by C-9 (T-1): correct one of them and "
        "certify again"
    )
    assert decide(result, tolerance(bias_limit()), (reason,)).verdict == "inconclusive"


@pytest.mark.parametrize("stated", [1e-5, 0.9e-5])
def test_a_budget_with_no_less_than_the_equipment_list_states_is_in_order(stated):
    assert smaller_than_stated(made_with(own()), [table(rate=stated)], DAY) == ()


def test_of_two_standards_for_one_property_the_worse_counts():
    reasons = smaller_than_stated(made_with(own()), [table(rate=1e-6), table(rate=2e-5)], DAY)
    assert ["±2×10⁻⁵" in say(reason, "en") for reason in reasons] == [True]


def by_function(deviation: str, rows: list[dict[str, float]]) -> MeasurementStandard:
    function = {
        "deviation": deviation, "rows": rows,
        "drift": {"per_year": 1e-6, "distribution": "rectangular"},
    }  # fmt: skip
    return MeasurementStandard.model_validate(
        table().model_dump() | {"functions": {"rate": function}, "calibrated_on": "2026-03-01"}
    )


ROWS = [{"at": 0.5, "deviation": 3e-5, "U": 1e-5}, {"at": 100.0, "deviation": 0.0, "U": 2e-6}]


def test_a_function_is_compared_where_it_is_largest():
    result = made_with(own())  # ±1e-5 rectangular: u = 5.8e-6
    assert smaller_than_stated(result, [by_function("corrected", ROWS)], DAY) == ()
    (reason,) = smaller_than_stated(result, [by_function("budgeted", ROWS)], DAY)
    assert "less than the ±4×10⁻⁵ (normal) stated for the equipment by C-9 (T-1)" in say(
        reason, "en"
    )


def test_a_failed_intermediate_check_gives_no_pass():
    passed, failed = (
        {"checked_on": "2026-05-04", "what": "rate at 100 °/s", "what_zh": "100 °/s 速率",
         "result": result, "limit": 1e-5, "unit": "1"} for result in (-1e-5, -1.1e-5)
    )  # fmt: skip
    kept = table().model_dump()
    in_order = MeasurementStandard.model_validate(kept | {"checks": [passed]})
    out = MeasurementStandard.model_validate(kept | {"checks": [passed, failed]})
    assert failed_checks([in_order]) == ()
    (reason,) = failed_checks([in_order, out])
    assert say(reason, "en") == (
        "Table (T-1): its intermediate check of 2026-05-04 (rate at 100 °/s) found −1.1×10⁻⁵, "
        "beyond the limit of ±1×10⁻⁵"
    )
    assert "期间核查（100 °/s 速率）" in say(reason, "zh")
    assert decide(made_with(own()), tolerance(bias_limit()), (reason,)).verdict == "inconclusive"


PARTY = Party(name="L", name_zh="实", address="a", address_zh="址")
BIAS_CAPABILITIES = {"x": 0.01, "y": -0.02, "z": 0.03}  # each U = 0.001


def capability(U: float, **more: Any) -> Capability:
    return Capability(**({"item": "gyro_bias", "unit": "deg/s", "U": U} | more))


def laboratory(*capabilities: Capability) -> Laboratory:
    return Laboratory(party=PARTY, capabilities=capabilities)


def result(*rates: float) -> Calibration:
    held = tuple(
        SegmentUsed(name=f"r{n}", kind="rate", t_start=0.0, t_end=1.0, origin="label", axis="x",
                    rate_deg_s=rate, rows=10)
        for n, rate in enumerate(rates)
    )  # fmt: skip
    return calibration({"gyro_bias": item(dict(BIAS_CAPABILITIES))}, segments=held)


def stated(*capabilities: Capability, rates: tuple[float, ...] = ()) -> dict[str, float | None]:
    return as_stated(result(*rates), laboratory(*capabilities)).items["gyro_bias"].U


def test_the_larger_of_u_and_capability_is_stated():
    assert stated(capability(0.004)) == {"x": 0.004, "y": 0.004, "z": 0.004}
    assert stated(capability(0.0004)) == {"x": 0.001, "y": 0.001, "z": 0.001}
    assert stated() == {"x": 0.001, "y": 0.001, "z": 0.001}


def test_a_relative_capability_is_of_the_value():
    relative = stated(capability(0.1, relative=True))
    assert relative == pytest.approx({"x": 0.001, "y": 0.002, "z": 0.003})


def test_of_ranges_the_largest_counts_among_those_that_hold_a_rate_of_the_run():
    ranges = [
        capability(0.004, rates_deg_s=(0.1, 10.0)), capability(0.002, rates_deg_s=(10.0, 400.0)),
    ]  # fmt: skip
    assert stated(*ranges, rates=(-5.0, 300.0))["x"] == 0.004
    assert stated(*ranges, rates=(20.0, -300.0))["x"] == 0.002
    assert stated(*ranges, rates=(20.0, 500.0))["x"] == 0.001  # 500 °/s: not covered
    assert stated(*ranges)["x"] == 0.001  # held at no rate


def test_a_range_of_values_covers_the_elements_within_it():
    assert stated(capability(0.004, values=(-0.02, 0.02))) == {"x": 0.004, "y": 0.004, "z": 0.001}


def test_a_decision_is_by_the_stated_u():
    """0.03 ± 0.001 lies inside 0.05 with its guard band; with a capability of 0.03 it does not."""
    limits = tolerance(bias_limit()).model_copy(
        update={"rule": "guard_band", "guard_band_factor": 1.0}
    )
    assert decide(result(), limits).verdict == "pass"
    decision = decide(as_stated(result(), laboratory(capability(0.03))), limits)
    of = {limit.element: limit for limit in decision.limits}
    assert (of["z"].U, of["z"].verdict) == (0.03, "fail")
    assert of["x"].accept_upper == pytest.approx(0.02)


def test_unknown_items_and_units_are_refused_all_at_once():
    wrong = [capability(1.0, item="gyro_bais"), capability(1.0), capability(1.0, unit="rad/s")]
    with pytest.raises(Unusable) as refused:
        check_capabilities(wrong)
    assert "capability 1 is of 'gyro_bais', which is none of" in str(refused.value)
    assert "capability 3 is in 'rad/s', but gyro_bias is in 'deg/s'" in str(refused.value)
    assert "capability 2" not in str(refused.value)


@pytest.mark.parametrize(
    ("first", "second", "overlaps"),
    [
        ({}, {}, True),
        ({"rates_deg_s": (1, 10)}, {}, True),
        ({"rates_deg_s": (1, 10)}, {"rates_deg_s": (9, 20)}, True),
        ({"rates_deg_s": (1, 10)}, {"rates_deg_s": (10, 20)}, False),
        ({"rates_deg_s": (1, 10)}, {"item": "accel_bias", "unit": "m/s2"}, False),
        ({"values": (-1, 0)}, {"values": (0, 1)}, False),
    ],
)
def test_ranges_of_one_item_do_not_overlap(first, second, overlaps):
    pair = capability(1e-3, **first), capability(1e-3, **second)
    if not overlaps:
        assert laboratory(*pair).capabilities == pair
        return
    with pytest.raises(ValidationError, match="capabilities 1 and 2 are both of gyro_bias"):
        laboratory(*pair)


@pytest.mark.parametrize(
    "wrong",
    [{"U": 0.0}, {"U": float("nan")}, {"rates_deg_s": (10, 1)}, {"rates_deg_s": (-10, 10)},
     {"values": (0, float("nan"))}],
)  # fmt: skip
def test_what_is_no_capability_is_refused(wrong):
    with pytest.raises(ValidationError):
        capability(**({"U": 1.0} | wrong))
