"""Certificates as the blind process writes them: as read, and less what was found."""

from dataclasses import replace
from typing import Any

import pytest

from schemas.recording import Recording
from tasks.explain.explain import explain
from tasks.explain.explanation import Explanation
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import simulate
from tests.proof.trial.blind import certificate_less, certificate_of
from tests.proof.trial.score import cost_of

CASE: dict[str, Any] = {"seed": 5, "rate_hz": 25, "dwell_s": 6.0, "rates_deg_s": (50.0, 200.0)}


@pytest.fixture(scope="module")
def turned_by_earth() -> tuple[Recording, Recording, Explanation]:
    """A run as read, the same without Earth's rotation, and what explain says of the first."""
    case = Case(**CASE, grade="tactical", effects=(EffectCall(name="earth_rotation"),))
    read, clean = simulate(case).recording, simulate(case.only()).recording
    return read, clean, explain(read)


def test_what_was_named_is_taken_off_and_the_certificate_comes_nearer(
    turned_by_earth: tuple[Recording, Recording, Explanation],
) -> None:
    read, clean, explanation = turned_by_earth
    less = certificate_less(read, explanation)
    cost = cost_of(certificate_of(clean), certificate_of(read), less, seed=1)
    assert cost is not None
    assert cost.worst.startswith("gyro_g_sensitivity")
    assert cost.after < 0.2 * cost.before


@pytest.mark.rehearsal
def test_what_is_unnamed_stays_on_the_readings(
    turned_by_earth: tuple[Recording, Recording, Explanation],
) -> None:
    read, _, explanation = turned_by_earth
    unnamed = tuple(replace(each, effect="unnamed") for each in explanation.findings)
    assert certificate_less(read, replace(explanation, findings=unnamed)) is None


def test_an_ahrs_gets_the_items_of_its_own_specification() -> None:
    ahrs = simulate(Case(seed=5, dwell_s=5.0, rates_deg_s=(200.0,), procedure="ahrs"))
    stated = certificate_of(ahrs.recording)
    assert stated is not None
    assert {name.split()[0] for name in stated["values"]} == {
        "ahrs_scale_factor", "ahrs_zero_offset", "ahrs_misalignment"
    }  # fmt: skip
