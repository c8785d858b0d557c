"""The evidence: what was asked beside what was reached, every failure, and the pictures."""

from dataclasses import replace
from xml.etree import ElementTree

import pytest

from tests.proof.tests.trial.answers import answered
from tests.proof.text import bilingual
from tests.proof.trial import failures
from tests.proof.trial.compare import Compared
from tests.proof.trial.evidence import Trial, as_data, as_markdown
from tests.proof.trial.failures import failing
from tests.proof.trial.figures import costs, figures
from tests.proof.trial.page import evidence_html
from tests.proof.trial.pictures.cases import cases_svg
from tests.proof.trial.pictures.cost import cost_svg
from tests.proof.trial.pictures.headline import headline_svg
from tests.proof.trial.pictures.power import effects_svg, families_svg
from tests.proof.trial.score import Gap, Score

LEVER = {"lever_arm": {"r": [0.001, 0.002, 0.003]}}
TILT = {"axis_tilt": {"east": 1e-4, "north": 0.0}}
CABLE = {"x_cable_drag": {"gyro": [1e-4, 0.0, 0.0]}}


@pytest.fixture
def scores() -> list[Score]:
    """Four kinds of recording: right, missed, outside and clean, with one false alarm."""
    right = answered(LEVER, "lever_arm")
    pairs = (Compared("r_x", "m", 0.0, 1.0, 0.5), Compared("r_y", "m", 0.0, 1.0, 5.0))
    return [
        replace(right, gap=Gap(1000.0, 20.0, 10.0), parameters=pairs),
        answered(LEVER, z=10.0),
        answered(CABLE, "unnamed", kind="outside"),
        answered({}, kind="clean", z=None),
        answered({}, "bias_step", kind="clean", z=None),
    ]


@pytest.fixture
def trial(scores: list[Score]) -> Trial:
    return Trial(3, False, "0.1.0+abc", "f" * 64, 60.0, scores)


def test_figures_stand_beside_what_was_asked(scores: list[Score]) -> None:
    response = {each.what.en: (each.reached, each.met) for each in figures(scores)}
    assert response == {
        "false alarms on clean recordings": ("50 %", False),
        "right name first, z = 30": ("100 %", True),
        "right name first, z = 10": ("0 %", False),
        "recordings with a wrong name": ("20 %", False),
        "outside the catalogue, yet given a name": ("0 %", True),
        "gap to the truth closed, median": ("0.980", True),
        "parameters inside their stated 95 % interval": ("50 %", False),
    }


def test_a_figure_without_cases_is_neither_met_nor_missed(scores: list[Score]) -> None:
    clean = [each for each in scores if not each.effects]
    assert {each.reached for each in figures(clean) if each.met is None} == {"–"}
    assert costs(clean) == []


def test_units_wrongly_passed_and_wrongly_failed_are_told_apart(scores: list[Score]) -> None:
    response = {line.what.en: (line.before, line.after) for line in costs(scores)}
    nothing, all_three = "0 % (0 of 3)", "100 % (3 of 3)"
    assert response["units that fail and are passed"] == (nothing, nothing)
    assert response["units that conform and are failed"] == (all_three, nothing)
    assert response["recordings on which nothing was noticed"] == (all_three, "33 % (1 of 3)")


def test_every_way_to_fail_has_its_name() -> None:
    several = answered(LEVER | TILT, "lever_arm", kind="several", z=40.0)
    assert failing(replace(several, failed="ValueError: no")) == "failed"
    assert failing(answered({}, "unnamed", kind="clean", z=None)) == "false alarm"
    assert failing(answered(LEVER, "lever_arm", "axis_tilt")) == "wrong"
    assert failing(answered(CABLE, "axis_tilt", kind="outside")) == "wrong"
    assert failing(answered(LEVER, "unnamed")) == "unnamed"
    assert failing(several) == "in part"
    assert failing(answered(LEVER)) == "missed"
    assert failing(answered(CABLE, kind="outside")) == "missed"


def test_what_is_right_does_not_fail() -> None:
    assert failing(answered(LEVER, "lever_arm", "unnamed")) is None
    assert failing(answered(LEVER, ("size_effect", "lever_arm"))) is None
    assert failing(answered(CABLE, "unnamed", kind="outside")) is None
    assert failing(answered({"gravity_value": {"difference": 1e-3}}, z=None)) is None
    assert failing(answered({}, kind="clean", z=None)) is None


def test_known_causes_are_found_by_what_is_true_and_what_was_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    cause = bilingual("a tilt acts like an arm here", "此处倾斜与杆臂作用相同")
    monkeypatch.setattr(failures, "KNOWN_CAUSES", {("lever_arm", "axis_tilt"): cause})
    assert failures.causes(answered(LEVER, "axis_tilt")) == (cause,)
    assert failures.causes(answered(LEVER | TILT, "lever_arm")) == (failures.NOT_KNOWN,)
    assert failures.causes(answered(LEVER, kind="faint", z=5.0)) == (failures.FAINT,)


def test_page_says_everything_in_both_languages_and_takes_further_sections(trial: Trial) -> None:
    html = evidence_html(trial, ["<h2>Peers</h2>", "<h2>Real recordings</h2>"])
    assert html.index("What fails") < html.index("<h2>Peers</h2>") < html.index("Real recordings")
    assert "3 of 5 recordings hide physics" in html
    assert "5个记录中有3个" in html
    assert html.count('class="tile ') == 6
    assert "make prove --seed 3<" in html
    assert trial.machine.python in html


def test_pictures_are_well_formed_and_draw_every_case(scores: list[Score]) -> None:
    pictures = [
        make(scores) for make in (headline_svg, families_svg, effects_svg, cost_svg, cases_svg)
    ]
    for picture in pictures:
        ElementTree.fromstring(picture)
    assert "geometry: effects 1, cases 2" in pictures[1]
    assert "x_cable_drag" in pictures[3]


def test_pictures_of_nothing_are_drawn_all_the_same() -> None:
    for make in (headline_svg, families_svg, effects_svg, cost_svg, cases_svg):
        ElementTree.fromstring(make([]))


def test_data_and_tables_hold_the_failures(trial: Trial) -> None:
    data = as_data(trial)
    assert [one["kind"] for one in data["failures"]] == ["false alarm", "missed"]
    assert data["command"] == "make prove --seed 3"
    assert "| lever_arm |" in as_markdown(trial)
    assert "| clean | – | bias_step |" in as_markdown(trial)
