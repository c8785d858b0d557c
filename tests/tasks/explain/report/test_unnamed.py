"""What has no name carries none: its title says where it sits, its statement why no name stands."""

import json
from typing import Any, get_args

import numpy as np
import pytest

from schemas.discrepancy import Dimension, ReportedFinding
from schemas.text import Statement
from tasks.explain.explanation import Partition, Refusal
from tasks.explain.report.discrepancy import next_of
from tasks.model.term import effect_name
from tasks.words import texts
from tests.tasks.explain.report.made_report import explanation, finding, located, unnamed, where

BEHAVIOUR = Statement(en="a change that follows the rate", zh="随角速率变化的偏差")
REFUSALS: dict[str, Refusal] = {
    "implausible": Refusal(
        "implausible", "gyro_scale_nonlinearity", "c_3", "1", value=-0.97, limit=-0.027
    ),
    "inhomogeneous": Refusal(
        "inhomogeneous", "time_offset", "delay", "s", smallest=0.008, largest=0.0094, parts="rate"
    ),
    "reference_noise": Refusal("reference_noise", "bandwidth"),
    "switching": Refusal("switching", "bias_random_walk"),
    "form_error": Refusal("form_error", "gyro_scale_asymmetry", value=360.0),
    "overshadowed": Refusal("overshadowed", "bias_random_walk", value=7.2, limit=41.0),
    "channel_worse": Refusal("channel_worse", "axis_wobble", channel=4, value=-30.0),
    "undetermined": Refusal(
        "undetermined", "magnetic_sensitivity", "gyro_x", "rad/s", value=1e-5, limit=2e-5
    ),
}


def refused(kind: str, **more: Any) -> ReportedFinding:
    found = unnamed(title=BEHAVIOUR, refusal=REFUSALS[kind], channels=(0, 1, 2), **more)
    return located(explanation(found, verdict="unexplained"), (where("gyro_x", 1.0),)).findings[0]


@pytest.mark.parametrize("kind", REFUSALS)
def test_a_refused_name_stands_in_the_statement_with_its_reason_and_never_in_the_title(
    kind,
):
    found = refused(kind)
    assert found.effect == "unnamed"
    assert found.refused is not None
    for language, name in texts(effect_name(REFUSALS[kind].name)).items():
        title, statement, why = (
            getattr(each, language) for each in (found.title, found.statement, found.refused)
        )
        assert name not in title
        assert REFUSALS[kind].name not in json.dumps(found.title.model_dump())
        assert name in why
        assert why in statement


def test_no_setting_is_suspected_where_much_is_left_all_the_same():
    found = unnamed(title=BEHAVIOUR, refusal=REFUSALS["implausible"], channels=(0, 1, 2))
    left = np.array([728.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    explained = explanation(found, verdict="unexplained", left_over=left)
    written = located(explained, (where("gyro_x", 1.0),)).findings[0]
    assert "36 times larger" in written.statement.en
    assert "another cause with the same time history" in written.statement.en
    assert "range or unit" not in written.statement.en
    assert "rigidly connected" in written.next.en


def test_a_name_that_was_ordered_stands_and_is_not_refused():
    ordered = finding(refusal=REFUSALS["undetermined"])
    written = located(explanation(ordered), (where(),)).findings[0]
    assert written.effect == "axis_tilt"
    assert written.refused is None


def test_a_pattern_of_its_own_is_what_the_finding_is_called_by():
    found = located(explanation(unnamed(), verdict="unexplained"), (where(),)).findings[0]
    assert found.refused is None
    assert found.follows is not None
    assert found.title.en == f"unnamed: {found.follows.en}"


@pytest.mark.parametrize("dimension", get_args(Dimension))
def test_every_circumstance_has_its_next_step(dimension):
    places = (where(dimension=dimension),)
    elsewhere = (where(dimension="level" if dimension != "level" else "rate"),)
    assert texts(next_of(unnamed(), places, False)) != texts(next_of(unnamed(), elsewhere, False))


@pytest.mark.parametrize("parts", get_args(Partition))
def test_every_way_of_parting_has_its_sentence_and_its_next_step(parts):
    refusal = Refusal("inhomogeneous", "time_offset", "delay", "s", smallest=1.0, largest=2.0,
                      parts=parts)  # fmt: skip
    made = located(explanation(unnamed(refusal=refusal), verdict="unexplained"), ())
    (found,) = made.findings
    other = refused("inhomogeneous") if parts != "rate" else refused("implausible")
    assert found.refused != other.refused
    assert found.next != other.next


def test_of_what_nothing_explains_is_said_how_much_stays_and_what_to_do():
    title = Statement(en="a remainder", zh="剩余残差")
    found = unnamed(title=title, share=0.0, delta_bic=0.0, held_out_gain=0.0, channels=(0,),
                    remainder=True)  # fmt: skip
    left = np.array([14.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    explained = explanation(found, verdict="unexplained", left_over=left)
    (written,) = located(explained, (where("gyro_x", 1.0),)).findings
    assert written.title.en == "unnamed: a remainder"
    assert "(noise at rest and of the reference = 1): gyro x 14.00" in written.statement.en
    assert "ΔBIC" not in written.statement.en
    assert written.statement.en.endswith(f"Next step: {written.next.en}.")
