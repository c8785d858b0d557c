"""A unit that was adjusted: its certificate has it as found beside what it is as left."""

import io
from datetime import date

import pypdf
import pytest
from sample_certificate import AXES, calibration, certificate, content, item, items, tolerance

from schemas.certificate import AsFound, Certificate
from tasks.certificate.pdf import render
from tasks.conformity import decide


def adjusted() -> Certificate:
    """The sample, whose y gyro bias was out of tolerance as found."""
    bias = item("deg/s", "7.2.2", AXES, [0.0125, -0.2514, 0.0071], 1.71e-4)
    before = calibration(items=items() | {"gyro_bias": bias}, run="r-as-found", digest="ab" * 32)
    found = AsFound(
        calibrated_on=date(2026, 11, 17),
        calibration=before,
        decision=decide(before, tolerance()),
    )
    return certificate(as_found=found)


def test_values_as_found_and_as_left_stand_in_one_row() -> None:
    section = content(adjusted()).as_found
    (bias,) = (group for group in section.groups if group.title[1] == "Gyro bias")
    _, y, _ = bias.rows
    assert (y.found, y.U_found, y.left, y.U_left) == ("−0.25140", "0.00035", "−0.03194", "0.00035")
    assert y.marks[0].words[1] == "fail"
    assert [row.marks[0].words[1] for row in bias.rows] == ["pass", "fail", "pass"]


def test_the_section_names_the_run_as_found_its_day_and_its_verdict() -> None:
    fields = {field.label[1]: field.value[1] for field in content(adjusted()).as_found.fields}
    assert fields["Run"] == "r-as-found"
    assert fields["Digest of the raw data"] == "ab" * 32
    assert fields["Date of calibration"] == "2026-11-17"
    assert fields["Verdict as found"] == "fail"


def test_verdict_is_that_as_left_and_the_cover_says_both() -> None:
    printed = content(adjusted())
    assert printed.verdict_text[1] == content(certificate()).verdict_text[1] == "pass"
    assert printed.scope[1].endswith("; as found, before it was adjusted: fail")


def test_a_limit_on_the_second_value_shows_that_value() -> None:
    """The g-sensitivity is limited less Earth's rotation, so that is what is compared."""
    made = adjusted()
    (group,) = (g for g in content(made).as_found.groups if g.title[1] == "Gyro g-sensitivity")
    assert group.quantity is not None
    value = made.calibration.items["gyro_g_sensitivity"].value_without_earth_rotation["xx"]
    assert float(group.rows[0].left) * 10**group.exponent == round(value, 5)


@pytest.mark.rehearsal
def test_the_section_is_printed_and_nothing_leaves_its_page() -> None:
    pages = pypdf.PdfReader(io.BytesIO(render(adjusted()))).pages
    texts = [page.extract_text() for page in pages]
    assert "as found, before it was adjusted: fail" in " ".join(texts[0].split())
    assert "Page 1 of" in texts[0]
    assert "Operator" in texts[0]
    assert "李明" in texts[0]
    assert sum("As found and as left" in text for text in texts) == 1
    assert sum("0.25140" in text for text in texts) == 1
