"""What a certificate cites: clauses and equations of its own specification and of no other."""

import re
from dataclasses import asdict

import pytest

from tasks.calibrate.calibrate import calibrate
from tasks.certificate.content import Content
from tasks.conformity import decide
from tasks.specifications.register import BY_STANDARD
from tests.tasks.certificate.sample_certificate import certificate, content

# The clauses and equations of the specifications' texts.
CLAUSES = {
    "JJF 2003-2022": {
        "5.1", "5.2", "6.1", "6.2", "7.2", "7.2.1", "7.2.1.1", "7.2.1.2", "7.2.2", "7.2.2.1",
        "7.2.2.2", "7.2.3", "7.2.3.1", "7.2.3.2", "7.2.4", "7.2.4.1", "7.2.4.2", "7.2.5",
        "7.2.5.1", "7.2.5.2",
    },
    "JJF 1536-2015": {
        "5.1", "5.2", "5.3", "5.4", "5.5", "5.6", "5.7", "5.8", "6.1", "6.2.1", "6.2.2", "7.1",
        "7.1.1", "7.1.2", "7.2", "7.2.1", "7.2.2", "7.2.3", "7.3", "7.3.1", "7.3.2",
    },
}  # fmt: skip
# By section of the results: what its own clauses calculate with.
EQUATIONS = {
    "ahrs_scale_factor": set(range(10, 16)), "ahrs_zero_offset": {16}, "ahrs_misalignment": {17},
    "gyro_scale_factor": {3, 4, 5}, "gyro_fit_offset": {3, 4, 5}, "gyro_bias": {6, 7, 8},
    "gyro_g_sensitivity": {6, 7, 8}, "gyro_cross_coupling": set(), "accel_bias": {9, 10, 11},
    "accel_scale_factor": {9, 10, 11}, "accel_cross_coupling": {9, 10, 11},
    "accel_rate_sensitivity": {12, 13},
}  # fmt: skip
RECORDINGS = {"JJF 2003-2022": "plant_clean", "JJF 1536-2015": "ahrs_clean"}
NUMBERED = re.compile(r"\((\d+)\)")
CITED = re.compile(r"(?<![\d.(])([5-9]\.\d(?:\.\d){0,2})(?![\d.]|\s*[×·%°])")


@pytest.fixture(scope="module", params=list(RECORDINGS))
def made(request, plant) -> tuple[str, Content, dict[str, str]]:
    """The specification, what its certificate says, and the clause of each item."""
    standard = request.param
    recording = plant(RECORDINGS[standard])
    result = calibrate(BY_STANDARD[standard], recording, run="r1", code_version="test")
    written = content(certificate(result, decide(result, None), manifest=recording.manifest))
    return standard, written, {name: item.clause for name, item in result.items.items()}


def test_each_item_cites_the_equations_of_its_own_specification(made):
    standard, _, clauses = made
    for name, clause in clauses.items():
        assert clause.startswith(standard) or re.match(r"\d", clause), (name, clause)
        numbers = [int(n) for n in NUMBERED.findall(clause)]
        cited = set(range(min(numbers), max(numbers) + 1)) if numbers else set()
        assert cited == EQUATIONS[name], (name, clause)
        assert set(CITED.findall(clause)) <= CLAUSES[standard], (name, clause)


def test_nothing_on_the_certificate_names_the_other_specification(made):
    standard, written, _ = made
    text = str(asdict(written))
    others = {"JJF 2003", "JJF 1536"} - {standard[:8]}
    assert not [other for other in others if other in text]


def test_every_reading_cites_clauses_that_its_specification_has(made):
    standard, written, _ = made
    for row in written.readings:
        found = set(CITED.findall(row.clause[1].removeprefix(standard)))
        assert found <= CLAUSES[standard], row.clause


def test_sentences_under_the_results_speak_of_equations_of_their_own_item(made):
    """Groups stand in the order of the items of their section."""
    standard, written, _ = made
    largest = 13 if standard.startswith("JJF 2003") else 17
    for section in written.sections:
        for group in section.groups:
            for _, en in group.sentences:
                for equations in re.findall(r"eq\. ((?:\(\d+\)[,–\- ]*)+)", en):
                    assert all(int(n) <= largest for n in NUMBERED.findall(equations)), en
