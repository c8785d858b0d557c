"""Advice on the interval of a unit from its own issued certificates."""

from datetime import date

import pytest

from schemas.base import Unusable
from schemas.certificate import AsFound, Certificate
from schemas.decision import Decision
from storage.catalogue import results, runs
from storage.home import Home
from tasks.stages.draft import keep_draft
from tasks.stages.issue import check, issue
from tasks.stages.remind import interval_advice, sentence
from tasks.words import say
from tests.drafts import DECIDED, MORNING, calibration_of, certificate_of, recording_of

pytestmark = pytest.mark.usefixtures("unprinted")

FAILED = Decision(verdict="fail", rule="simple", document="Data sheet", limits=DECIDED.limits)
UNDECIDED = DECIDED.model_copy(update={"verdict": "inconclusive"})


def issued(home: Home, year: int, decision: Decision = DECIDED, **changes: object) -> Certificate:
    """A certificate of unit 7 from a calibration on 1 March of a year."""
    recording = recording_of("7")
    manifest = recording.manifest.model_copy(update={"recording_id": f"of {year}"})
    other = type(recording)(manifest, recording.imu)
    run, _ = runs.add(other, home)
    calibration = calibration_of(run)
    results.save(calibration, home)
    days: dict[str, object] = {"calibrated_on": date(year, 3, 1), "due": date(year + 1, 3, 1)}
    made = certificate_of(run, calibration, decision=decision, **(days | changes))
    key = keep_draft(made, home, MORNING).certificate.number
    check(key, home, "Li")
    return issue(key, home, "Zhao").certificate


def test_the_verdict_as_found_counts_and_what_was_inconclusive_does_not(home: Home) -> None:
    issued(home, 2018)
    issued(home, 2019)
    issued(home, 2020, UNDECIDED)
    issued(home, 2021)
    as_left = issued(home, 2022)
    found = AsFound(
        calibrated_on=date(2023, 2, 28), calibration=as_left.calibration, decision=FAILED
    )
    issued(home, 2023, as_found=found)
    unit, agreed, advice = interval_advice("7", home)
    assert (unit, agreed) == ("Maker U 7", 366)
    assert (advice.intervals, advice.conforming, advice.advice) == (4, 3, "shorten")
    text = sentence(unit, agreed, advice)
    assert "within its limits after 3 of 4 intervals" in say(text, "en")
    assert "应予缩短" in say(text, "zh")


def test_a_young_unit_keeps_its_interval(home: Home) -> None:
    issued(home, 2024)
    issued(home, 2025)
    unit, agreed, advice = interval_advice("7", home)
    assert "too few for the reliability method" in say(sentence(unit, agreed, advice), "en")


def test_without_an_agreed_date_there_is_nothing_to_advise_on(home: Home) -> None:
    issued(home, 2020, due=None)
    with pytest.raises(Unusable, match=r"has no recalibration date .*recalibration_agreed"):
        interval_advice("7", home)
