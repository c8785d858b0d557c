"""The judge of the virtual station: its cases, its scores, and one recording explained."""

from typing import Any

import pytest

from tasks.explain.explain import explain
from tests.proof.station import CORNERS_HZ, Case, cases, recording_of, score
from tests.proof.trial.blind import as_data

BOTH = Case(3, "jjf2003", True, True)
LOW_PASS = Case(1, "jjf2003", True, False)


def finding(effect: str, group: tuple[str, ...] = (), **values: tuple[float, float]) -> dict:
    stated = [{"name": n, "value": v, "u": u} for n, (v, u) in values.items()]
    return {"effect": effect, "group": list(group), "parameters": stated, "common": stated}


def scored(case: Case, *findings: dict[str, Any]):
    return score(case, {"findings": findings, "seconds": 1.0})


def test_eighty_hold_every_condition_with_both_procedures() -> None:
    first = cases(80)
    assert len(set(first)) == 80
    kinds = {(c.procedure, c.has_low_pass, c.has_delay, c.is_loaded) for c in first}
    assert len(kinds) == 16
    assert len(set(cases(160))) == 160
    corners = [hz for case in first for hz in case.corners_hz or ()]
    assert CORNERS_HZ[0] <= min(corners) < 20.0
    assert 60.0 < max(corners) <= CORNERS_HZ[1]


def test_a_name_that_is_not_true_of_the_unit_is_wrong() -> None:
    assert scored(LOW_PASS, finding("gyro_angular_acceleration")).wrong == (
        "gyro_angular_acceleration",
    )
    assert scored(LOW_PASS, finding("time_offset", seconds=(0.004, 1e-5))).delay == "invented"
    assert scored(LOW_PASS, finding("size_effect", r_zz=(0.005, 1e-4))).wrong == ("size_effect",)
    assert scored(LOW_PASS, finding("size_effect", r_zz=(0.005, 0.02))).wrong == ()


def test_a_group_is_right_where_it_holds_the_truth_and_its_common_part_does() -> None:
    group = ("bandwidth", "time_offset")
    gyro, accel = BOTH.group_delays_s
    true = {"gyro_group_delay": (gyro, 1e-5), "accel_group_delay": (accel, 1e-5)}
    declared = scored(BOTH, finding("time_offset", group, **true))
    assert (declared.low_pass, declared.delay, declared.wrong) == ("group", "group", ())
    assert declared.is_right
    off = true | {"gyro_group_delay": (gyro + 1e-3, 1e-5)}
    assert not scored(BOTH, finding("time_offset", group, **off)).is_right


def test_what_is_not_told_is_not_right() -> None:
    assert not scored(LOW_PASS).is_right
    assert scored(Case(1, "jjf2003", False, False)).is_right


@pytest.mark.rehearsal
@pytest.mark.timeout(120)
def test_the_delay_of_an_ahrs_is_told_by_its_angles() -> None:
    late = Case(4, "jjf1536", True, True)
    declared = score(late, as_data(explain(recording_of(late))) | {"seconds": 0.0})
    assert (declared.delay, declared.wrong) == ("group", ())
    assert declared.is_right
