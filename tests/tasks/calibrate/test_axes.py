"""Axes of the mounting plane count the tilt of the unit's base; those of the fixture do not."""

from collections.abc import Callable

import pytest

from schemas.calibration import Calibration
from schemas.laboratory import EquipmentLimit, ResultAxes
from tasks.calibrate.calibrate import EXAMPLE, evaluation_for
from tasks.specifications.jjf2003 import JJF2003
from tests.own_limits import as_table_1
from tests.tasks.items_only import items_only

MOUNTING = EquipmentLimit(half_width=2e-4, distribution="rectangular", source="drawing F-7")
CODE = "mounting_unknown"


@pytest.fixture(scope="module")
def made(ideal_run) -> Callable[..., Calibration]:
    recording = ideal_run(dwell=1.0)

    def build(axes: ResultAxes | None, stated: bool) -> Calibration:
        own = as_table_1() | ({"mounting": MOUNTING} if stated else {})
        return items_only(JJF2003, recording, evaluation_for(recording, own=own, axes=axes))

    return build


def tilts(calibration: Calibration) -> bool:
    budgets = calibration.items["gyro_cross_coupling"].budgets.values()
    return any(line.symbol == "α6" for budget in budgets for line in budget.inputs)


@pytest.mark.parametrize(
    ("axes", "stated", "about", "counted", "blocked"),
    [
        (None, False, "fixture", False, False),
        (None, True, "mounting plane", True, False),
        ("fixture", True, "fixture", False, False),
        ("mounting plane", True, "mounting plane", True, False),
        ("mounting plane", False, "mounting plane", False, True),
    ],
)
def test_the_limit_of_the_mounting_counts_for_the_mounting_plane_alone(
    made, axes, stated, about,
    counted, blocked
):  # fmt: skip
    result = made(axes, stated)
    assert result.settings["axes"] == about
    assert tilts(result) is counted
    assert ("limit of mounting" in result.settings) is counted
    blocking = [remark for remark in result.remarks if remark.code == CODE]
    assert [remark.blocks_pass for remark in blocking] == [True] * blocked


def test_the_tilt_makes_a_cross_coupling_as_uncertain_as_it_is(made):
    of_plane, of_fixture = (made(axes, True) for axes in ("mounting plane", "fixture"))
    u = [each.items["gyro_cross_coupling"].u["xy"] for each in (of_plane, of_fixture)]
    assert (u[0] ** 2 - u[1] ** 2) ** 0.5 == pytest.approx(2e-4 / 3**0.5, rel=1e-3)


def test_a_budget_as_in_the_appendix_has_no_mounting_to_count(ideal_run):
    recording = ideal_run(dwell=1.0)
    example = evaluation_for(recording, EXAMPLE, {"mounting": MOUNTING})
    assert example.settings["axes"] == "fixture"
    ordered = evaluation_for(recording, EXAMPLE, {"mounting": MOUNTING}, "mounting plane")
    assert [remark.code for remark in ordered.remarks] == [CODE]
