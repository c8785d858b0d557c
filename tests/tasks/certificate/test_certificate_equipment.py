"""Whose limits stand in the budgets, and what stands in none."""

from typing import get_args

import pytest
from sample_certificate import printed

from schemas.equipment import EquipmentLimit, LimitName, ResultAxes
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.evaluation import evaluation_for
from tasks.certificate.budgets import budgets
from tasks.certificate.equipment import axes_of_results, flatness, limits_of, whose_limits
from tasks.certificate.settings import settings
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.joint import JOINT
from tasks.words import say

OWN = EquipmentLimit(half_width=2e-6, distribution="normal", source="CNAS 2026-117")


@pytest.fixture(scope="module")
def made(ideal_run):
    """A result for each set of limits of a laboratory's own."""

    def build(about: ResultAxes | None = None, **own: EquipmentLimit):
        recording = ideal_run(noise=1e-4)
        evaluation = evaluation_for(recording, own=own, axes=about)
        return calibrate(JJF2003, recording, run="r", code_version="v", evaluation=evaluation)

    return build


def test_recommended_and_assumed_limits_are_said_to_be_such(made) -> None:
    ((zh, en),) = printed(whose_limits(made()))
    assert "limits recommended by JJF 2003-2022, Table 1, JJF 2003-2022, 6.2, which this" in en
    assert "local gravity assumed known to ±0.0005 m/s²" in en
    assert "latitude assumed known to ±0.05°" in en
    assert "JJF 2003—2022，表 1" in zh
    assert "纬度假定已知至 ±0.05°" in zh


def test_which_axes_the_results_are_about_is_always_stated(made) -> None:
    """It agrees with what is stated of the flatness: that is in no budget of the fixture's axes."""
    zh, en = printed(axes_of_results(made()))
    ((flat_zh, flat_en),) = printed(tuple(flatness(made(), JJF2003)))
    assert "hold for the axes of the fixture" in en
    assert "以夹具的轴线为准" in zh
    assert "0.02 mm" in flat_en
    assert "41″" in flat_zh
    mounted = made(mounting=OWN)
    zh, en = printed(axes_of_results(mounted))
    assert not list(flatness(mounted, JJF2003))
    assert "axes of the unit's mounting plane" in en
    assert "安装基面的轴线为准" in zh
    ordered = made("mounting plane")
    _, en = printed(axes_of_results(ordered))
    ((_, flat_en),) = printed(tuple(flatness(ordered, JJF2003)))
    assert "ordered for the axes of the unit's mounting plane" in en
    assert "0.02 mm" in flat_en
    names = [say(each.name, "en") for each in settings(ordered)]
    assert "axes of the results" in names


def test_a_limit_of_the_laboratory_is_not_called_recommended_or_assumed(made) -> None:
    result = made(rate=OWN, gravity=OWN)
    ((_, en),) = printed(whose_limits(result))
    own, others = en.split("limits recommended")
    assert "stated by the laboratory: table rate over whole turns, local gravity" in own
    assert "table rate over whole turns" not in others
    assert "local gravity assumed" not in others
    found = printed(budgets(result))
    assert found is not None
    rows = {row.symbol: row for row in found.limits}
    assert rows["ε1"].source == ("CNAS 2026-117",) * 2
    assert (rows["ε1"].half_width, rows["ε1"].distribution[1]) == ("U = 2×10⁻⁶", "normal")
    assert rows["α1"].half_width == "±10″"
    assert rows["α4"].source == ("JJF 2003—2022，6.2", "JJF 2003-2022, 6.2")


def test_table_1_is_no_setting_where_every_limit_is_the_laboratorys_own(made) -> None:
    def printed_settings(**own: EquipmentLimit) -> str:
        return " ".join(say(each.value, "en") for each in settings(made(**own)))

    assert "Table 1" in printed_settings(rate=OWN)
    own = printed_settings(**dict.fromkeys(get_args(LimitName), OWN))
    assert "Table 1" not in own
    assert own.count("CNAS 2026-117") == len(get_args(LimitName))


def test_the_joint_method_has_the_assumed_latitude_among_its_limits(ideal_run) -> None:
    result = calibrate(JOINT, ideal_run(noise=1e-4), run="r", code_version="v")
    rows = {row.symbol: row for row in printed(budgets(result)).limits}
    assert rows["φ"].source[1] == "assumed: latitude stated to 0.1°"
    assert rows["φ"].half_width == "±0.05°"
    ((_, en),) = printed(whose_limits(result))
    assert en.count("latitude assumed") == 1


def test_a_budget_line_carries_the_half_width_and_the_source_of_its_limit(made) -> None:
    limits = {line.symbol: line for line in limits_of(made())}
    assert limits["g"].half_width == 5e-4
    assert limits["g"].u == pytest.approx(5e-4 / 3**0.5)
    assert limits["α4"].source == "JJF 2003-2022, 6.2"
