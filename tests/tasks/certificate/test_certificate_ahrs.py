"""The pages after Appendix C of JJF 1536-2015: order, wording, positions, turns."""

from dataclasses import asdict
from typing import Any

import pytest

from schemas.certificate import Certificate
from tasks.calibrate.calibrate import calibrate
from tasks.certificate.content import Content
from tasks.conformity import decide
from tasks.specifications.jjf1536 import JJF1536
from tests.tasks.certificate.sample_certificate import certificate, content

# Clause 5.6 to 5.8: X turns, Y reads is “X axis to Y axis”, L_yx; the order of Appendix C.
ORDER = [("X", "Y", "yx"), ("X", "Z", "zx"), ("Y", "X", "xy"), ("Y", "Z", "zy"),
         ("Z", "X", "xz"), ("Z", "Y", "yz")]  # fmt: skip


@pytest.fixture(scope="module")
def made(plant) -> Certificate:
    recording = plant("ahrs_clean")
    result = calibrate(JJF1536, recording, run="r1", code_version="test")
    return certificate(result, decide(result, None), manifest=recording.manifest)


@pytest.fixture(scope="module")
def written(made) -> Content:
    return content(made)


def fields(made: Content) -> dict[str, Any]:
    return {field.label[1]: field.value for field in made.conditions.fields}


def test_misalignment_is_called_by_the_axis_that_turns_and_then_the_one_that_reads(written):
    rows = written.sections[2].groups[0].rows
    assert [(row.name[0], row.sub) for row in rows] == [
        (f"{turns} 轴对 {reads} 轴失准角", element) for turns, reads, element in ORDER
    ]
    assert rows[0].name[1] == "Misalignment of the X axis to the Y axis"


def test_positions_and_turns_of_the_clauses_are_told(written):
    document = fields(written)
    assert document["Positions for the zero offset"] == (
        "X 轴 4 个，各 1800 s；Y 轴 4 个，各 1800 s；Z 轴 4 个，各 1800 s",
        "X axis: 4 of 1800 s each; Y axis: 4 of 1800 s each; Z axis: 4 of 1800 s each",
    )
    assert document["Whole turns"][1].startswith("X axis: +10, −10 turns at 100 °/s; Y axis: ")
    assert document["Whole turns"][0].startswith("X 轴 +10, −10 周，100 °/s；Y 轴 ")


def test_clauses_are_in_chinese_where_the_page_is(written):
    chinese = [reading.clause[0] for reading in written.readings]
    assert not [zh for zh in chinese if "eq." in zh or "Table" in zh or " to " in zh]
    assert any("表 3" in zh for zh in chinese)
    assert any("式(A.4)" in zh for zh in chinese)


def test_the_register_says_which_index_turns(written):
    statement = str(asdict(written)["readings"])
    assert "X 轴对 Y 轴失准角为 L_yx" in statement
