"""No U below the laboratory's capability is decided on; the result keeps its own."""

from typing import Any

import pytest
from pydantic import ValidationError
from sample_results import bias_limit, calibration, item, tolerance

from schemas.base import Unusable
from schemas.calibration import Calibration, SegmentUsed
from schemas.capability import Capability
from schemas.certificate import Laboratory, Party
from tasks.conformity import as_stated, check_capabilities, decide
from tasks.conformity.capabilities import raised_elements

PARTY = Party(name="L", name_zh="实", address="a", address_zh="址")
BIAS = {"x": 0.01, "y": -0.02, "z": 0.03}  # each U = 0.001


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
    return calibration({"gyro_bias": item(dict(BIAS))}, segments=held)


def stated(*capabilities: Capability, rates: tuple[float, ...] = ()) -> dict[str, float | None]:
    return as_stated(result(*rates), capabilities).items["gyro_bias"].U


def test_the_larger_of_u_and_capability_is_stated() -> None:
    assert stated(capability(0.004)) == {"x": 0.004, "y": 0.004, "z": 0.004}
    assert stated(capability(0.0004)) == {"x": 0.001, "y": 0.001, "z": 0.001}
    assert stated() == {"x": 0.001, "y": 0.001, "z": 0.001}


def test_a_relative_capability_is_of_the_value() -> None:
    relative = stated(capability(0.1, relative=True))
    assert relative == pytest.approx({"x": 0.001, "y": 0.002, "z": 0.003})


def test_the_result_itself_is_left_alone() -> None:
    made = result()
    before = made.model_dump_json()
    as_stated(made, [capability(0.004)])
    assert made.model_dump_json() == before


def test_of_ranges_the_largest_counts_among_those_that_hold_a_rate_of_the_run() -> None:
    ranges = [
        capability(0.004, rates_deg_s=(0.1, 10.0)), capability(0.002, rates_deg_s=(10.0, 400.0)),
    ]  # fmt: skip
    assert stated(*ranges, rates=(-5.0, 300.0))["x"] == 0.004
    assert stated(*ranges, rates=(20.0, -300.0))["x"] == 0.002
    assert stated(*ranges, rates=(20.0, 500.0))["x"] == 0.001  # 500 °/s: not covered
    assert stated(*ranges)["x"] == 0.001  # held at no rate


def test_a_range_of_values_covers_the_elements_within_it() -> None:
    assert stated(capability(0.004, values=(-0.02, 0.02))) == {"x": 0.004, "y": 0.004, "z": 0.001}


def test_a_decision_is_by_the_stated_u() -> None:
    """0.03 ± 0.001 lies inside 0.05 with its guard band; with a capability of 0.03 it does not."""
    limits = tolerance(bias_limit()).model_copy(
        update={"rule": "guard_band", "guard_band_factor": 1.0}
    )
    assert decide(result(), limits).verdict == "pass"
    decision = decide(as_stated(result(), [capability(0.03)]), limits)
    of = {limit.element: limit for limit in decision.limits}
    assert (of["z"].U, of["z"].verdict) == (0.03, "fail")
    assert of["x"].accept_upper == pytest.approx(0.02)


def test_which_u_were_raised_is_known() -> None:
    partly = laboratory(capability(0.0015, relative=False, values=(0.0, 1.0)))
    assert raised_elements(result(), partly) == {"gyro_bias": ("x", "z")}
    assert raised_elements(result(), laboratory()) == {}
    assert raised_elements(result(), None) == {}


def test_unknown_items_and_units_are_refused_all_at_once() -> None:
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
def test_ranges_of_one_item_do_not_overlap(first: Any, second: Any, overlaps: bool) -> None:
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
def test_what_is_no_capability_is_refused(wrong: Any) -> None:
    with pytest.raises(ValidationError):
        capability(**({"U": 1.0} | wrong))
