"""What the certificate prints beside the results, and what it says the clause's value contains."""

from collections.abc import Callable
from typing import Any

import pypdfium2
import pytest
from sample_certificate import calibration, certificate, content, printed

from schemas.calibration import Information
from schemas.recording import Recording
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.information.earth import WITHOUT_EARTH, separated
from tasks.certificate.information import contained, information_rows
from tasks.certificate.pdf import render
from tasks.specifications.jjf2003 import JJF2003
from tasks.specifications.register import SPECIFICATIONS


def noise(**changes: Any) -> Information:
    given: dict[str, Any] = {
        "title": "Angle random walk of the gyros",
        "title_zh": "陀螺角度随机游走系数",
        "unit": "deg/sqrt(h)",
        "value": {"x": 0.08433, "y": None, "z": 0.0841},
        "u": {"x": 0.00067, "y": None, "z": 0.0006},
        "U": {"x": 0.00134, "y": None, "z": 0.0012},
        "en": "From 18 rests. y: the noise is masked by the output's resolution.",
        "zh": "由 18 段静止数据求得。y：输出分辨力掩盖了噪声。",
    }
    return Information(**(given | changes))


def test_numbers_are_rounded_to_the_place_of_u_and_u_upward() -> None:
    (row,) = printed(information_rows(calibration(information={"walk": noise()})))
    x, y, z = row.lines[0]
    assert (x.element, x.value, x.U) == ("x", "0.0843", "0.0014")
    assert (y.value, y.U) == (None, None)
    assert (z.value, z.U) == ("0.0841", "0.0012")
    assert row.unit == "°/√h"


def test_a_value_without_u_has_three_digits_and_no_more() -> None:
    shown = noise(value={"x": 582.0471}, u={"x": 205.8}, U={"x": None})
    (row,) = printed(information_rows(calibration(information={"s": shown})))
    ((x, _, _),) = row.lines
    assert (x.value, x.U, row.exponent) == ("582", None, 0)


def test_elements_of_a_matrix_stand_where_a_matrix_has_them() -> None:
    value = {"xy": 1.0, "yx": 2.0}
    shown = noise(value=value, u=None, U=None)
    (row,) = printed(information_rows(calibration(information={"p": shown})))
    names = [[cell and cell.element for cell in line] for line in row.lines]
    assert names == [[None, "xy", None], ["yx", None, None]]


def test_the_item_says_what_the_clause_contains_and_how_many_times_u() -> None:
    made = calibration()
    made = calibration(information=separated(made.items["gyro_g_sensitivity"], None))
    ((zh, en),) = printed(contained(made, "gyro_g_sensitivity", SPECIFICATIONS[made.method]))
    assert en.startswith("The value by eq. (7) includes Earth's rotation:")
    assert "0.0027 (°/s)/g, 11 times U" in en
    assert "即 U 的 11 倍" in zh


def test_a_value_of_the_joint_method_is_not_said_to_follow_an_equation() -> None:
    made = calibration()
    made = calibration(
        information=separated(made.items["gyro_g_sensitivity"], None), method="joint"
    )
    ((zh, en),) = printed(contained(made, "gyro_g_sensitivity", SPECIFICATIONS[made.method]))
    assert en.startswith("The value includes Earth's rotation:")
    assert zh.startswith("上述值含地球自转：")


def test_a_difference_within_u_is_not_mentioned_at_the_item() -> None:
    made = calibration()
    item = made.items["gyro_g_sensitivity"]
    close = {e: v - 0.5 * item.U[e] for e, v in item.value.items()}
    shown = separated(made.items["gyro_g_sensitivity"], None)[WITHOUT_EARTH].model_copy(
        update={"value": close}
    )
    assert (
        contained(
            calibration(information={WITHOUT_EARTH: shown}),
            "gyro_g_sensitivity",
            SPECIFICATIONS["jjf2003"],
        )
        == ()
    )


def test_information_never_enters_the_decision() -> None:
    far = noise(value={"x": 1e9, "y": 1e9, "z": 1e9}, about="gyro_bias")
    bare, shown = certificate(), certificate(calibration(information={"walk": far}))
    assert content(shown).verdict == content(bare).verdict
    assert content(shown).reasons == content(bare).reasons


@pytest.mark.rehearsal
def test_the_pdf_has_the_section_only_where_there_is_something_to_show() -> None:
    shown = certificate(calibration(information={"walk": noise()}))
    assert "For information, not decided on" in text_of(render(shown))
    assert "For information, not decided on" not in text_of(render(certificate()))


@pytest.mark.rehearsal
def test_on_plant_earth_rotation_the_certificate_says_what_the_clause_contains(
    plant: Callable[[str], Recording],
) -> None:
    made = calibrate(JJF2003, plant("plant_earth_rotation"), run="r", code_version="v")
    text = text_of(render(certificate(made)))
    assert "The value by eq. (7) includes Earth's rotation" in text
    assert "式(7)的值含地球自转" in text
    assert "附加信息（不作判定）" in text


@pytest.mark.rehearsal
def test_on_plant_lever_arm_the_certificate_says_that_p_contains_it_and_shows_it_without(
    plant: Callable[[str], Recording],
) -> None:
    made = calibrate(JJF2003, plant("plant_lever_arm"), run="r", code_version="v")
    text = text_of(render(certificate(made)))
    assert "The value by eq. (12), (13) contains the lever arm" in text
    assert "式(12)、式(13)的值含杆臂" in text
    assert made.information["lever_arm"].title in text


def text_of(pdf: bytes) -> str:
    """The words of a PDF, line ends and spaces made one space."""
    pages = pypdfium2.PdfDocument(pdf)
    text = " ".join(page.get_textpage().get_text_range() for page in pages)
    return " ".join(text.split())
