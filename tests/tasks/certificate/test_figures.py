"""The figures of a certificate: drawn from its curves, named in its languages, never empty."""

import io
import re
from datetime import date
from functools import cache

import pypdf
import pypdfium2
import pytest

from schemas.calibration import Calibration
from schemas.certificate import Certificate
from schemas.recording import Curve
from tasks.calibrate.calibrate import calibrate, evaluation_for
from tasks.certificate.budgets import Figure, budgets, figure
from tasks.certificate.figures import _power, drawn, history_curves
from tasks.certificate.pdf import render
from tasks.specifications.jjf2003 import JJF2003
from tests.tasks.certificate.sample_certificate import (
    calibration,
    certificate,
    content,
    item,
    items,
)

DAY = date(2026, 11, 19)


def curve(figure: str, quantity: str, axis: str, **changes: object) -> Curve:
    made = {
        "figure": figure, "quantity": quantity, "axis": axis, "x_unit": "deg/s", "y_unit": "deg/s",
        "x": (-300.0, 0.5, 300.0), "y": (2e-4, -4e-4, 2e-4), "U": (4e-3, 1e-4, 4e-3), "k": 2.0,
    }  # fmt: skip
    return Curve.model_validate(made | changes)


def with_curves() -> Certificate:
    positions = {
        "x_unit": "1",
        "y_unit": "m/s2",
        "x": (1.0, 2.0, 3.0),
        "labels": ("+x", "+x", "-x"),
    }
    levels = {"x_unit": "s", "y_unit": "deg/h", "x": (0.05, 1.0, 20.0), "y": (46.0, 10.0, 2.5),
              "U": (0.7, 0.5, 0.4)}  # fmt: skip
    return certificate(
        curves=(
            *(curve("rate-residuals", "gyro_scale_factor", axis) for axis in "xyz"),
            *(curve("tumble", "accel_bias", axis, **positions) for axis in "xyz"),
            *(curve("allan", "gyro", axis, **levels) for axis in "xyz"),
        )
    )


def issued_on(day: date, number: str, bias: float, method: str = "jjf2003") -> Certificate:
    one = item("deg/s", "7.2.2", "xyz", [bias, -0.03, 0.007], 1.7e-4)
    result = calibration(items=items() | {"gyro_bias": one}, method=method)
    return certificate(result, calibrated_on=day, number=number, order=None)


def test_the_history_has_earlier_certificates_of_the_method_in_order_and_ends_at_this_one():
    earlier = [
        issued_on(date(2025, 11, 19), "M-2", 0.5),
        issued_on(date(2024, 11, 19), "M-1", 0.7),
        issued_on(date(2025, 1, 1), "M-J", 0.9, method="joint"),
        issued_on(date(2026, 12, 1), "M-LATER", 0.9),
    ]
    found = {(c.quantity, c.axis): c for c in history_curves(issued_on(DAY, "M-3", 0.4), earlier)}
    bias = found["gyro_bias", "x"]
    assert bias.labels == ("M-1", "M-2")
    assert bias.x == (-730.0, -365.0, 0.0)
    assert bias.y == pytest.approx((0.3, 0.1, 0.0))
    assert bias.U == (3.4e-4,) * 3
    # The fit offset, which Table 2 does not ask for, has none.
    assert {quantity for quantity, _ in found} == {
        "gyro_scale_factor", "gyro_bias", "accel_scale_factor", "accel_bias",
    }  # fmt: skip


def test_a_unit_without_earlier_certificates_or_day_has_no_history():
    assert list(history_curves(certificate(), [])) == []
    assert list(history_curves(certificate(calibrated_on=None), [certificate()])) == []


def test_every_figure_has_title_and_caption_in_both_languages_and_what_is_absent_is_left_out():
    made = with_curves()
    titles = [figure.title for figure in content(made).figures]
    assert titles == [
        ("残差与角速率的关系", "Residuals over angular rate"),
        ("多位置试验的残差", "Residuals in the positions of the tumble"),
        ("Allan 标准差", "Allan deviation"),
    ]
    assert sorted(drawn(made)) == ["allan", "rate-residuals", "tumble"]
    assert content(certificate()).figures == ()
    pages = pypdfium2.PdfDocument(render(certificate(), ["en"]))
    assert "Figures" not in "".join(page.get_textpage().get_text_bounded() for page in pages)


@pytest.mark.parametrize(
    ("unit", "largest", "read"),
    [("ppm", 3600.0, (1e-4, "%")), ("ppm", 90.0, (1.0, "ppm")), ("deg/s", 2e-4, (1e6, "10⁻⁶ °/s"))],
)
def test_an_axis_has_a_unit_that_people_write(unit, largest, read):
    one = curve("rate-residuals", "gyro_scale_factor", "x", y_unit=unit, y=(largest,) * 3)
    assert _power([one.model_copy(update={"U": (0.0,) * 3})]) == read


def test_what_is_written_in_a_figure_is_outlines_so_that_no_font_is_missing():
    made = with_curves()
    for svg in drawn(made).values():
        assert "<text" not in svg
        assert "<image" not in svg
    page_of_figures = next(
        page for page in pypdf.PdfReader(io.BytesIO(render(made, ["en"]))).pages
        if "Allan deviation" in page.extract_text()
    )  # fmt: skip
    fonts = page_of_figures["/Resources"]["/Font"].values()
    for font in fonts:
        descriptor = font.get_object()["/DescendantFonts"][0].get_object()["/FontDescriptor"]
        assert {"/FontFile2", "/FontFile3"} & set(descriptor.get_object())
    assert "300" not in page_of_figures.extract_text().partition("Allan deviation")[0]


# The budgets on request: the lines of the largest element, and the sums of every element.

EXAMPLE = "as the specification's example"


@pytest.fixture(scope="module")
def made(ideal_run) -> Calibration:
    return calibrate(JJF2003, ideal_run(noise=1e-4), run="r", code_version="v")


def printed(made: Calibration, wanted: bool) -> Certificate:
    return certificate(made).model_copy(update={"budgets": wanted})


@cache
def text_of(pdf: bytes) -> str:
    pages = pypdfium2.PdfDocument(pdf)
    return re.sub(r"\s+", " ", " ".join(page.get_textpage().get_text_range() for page in pages))


def test_every_item_has_the_lines_of_its_most_uncertain_element(made):
    found = budgets(made)
    assert found is not None
    assert len(found.tables) == len(made.items)
    for table, estimated in zip(found.tables, made.items.values(), strict=True):
        largest = max(estimated.budgets.values(), key=lambda budget: budget.u_c)
        assert len(table.lines) == len(largest.inputs)
        assert [line.u for line in table.lines] == [figure(each.u) for each in largest.inputs]
        assert table.of in {element.name for element in table.elements}
        assert len(table.elements) == len(estimated.budgets)
        assert table.k == f"{estimated.k:g}"


def test_type_a_and_type_b_make_up_the_combined_uncertainty(made):
    found = budgets(made)
    assert found is not None

    def size(shown: Figure) -> float:
        return float(shown.digits) * 10.0**shown.exponent

    for table in found.tables:
        for element in table.elements:
            together = (size(element.of_data) ** 2 + size(element.of_equipment) ** 2) ** 0.5
            assert size(element.u_c) == pytest.approx(together, rel=0.01)


def test_as_the_example_it_is_said_how_it_was_done(ideal_run):
    recording = ideal_run()
    evaluation = evaluation_for(recording, EXAMPLE)
    made = calibrate(JJF2003, recording, run="r", code_version="v", evaluation=evaluation)
    words = text_of(render(printed(made, True)))
    assert "As in Appendix A of the specification" in words
    assert "effective bits: 12 (as in the specification's example)" in words
    assert "95 % half width" not in words


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, Figure("0")),
        (1.0, Figure("1.00")),
        (57.2958, Figure("57.3")),
        (-0.1019, Figure("−0.102")),
        (9999.6, Figure("1.00", 4)),
        (2.7987e-5, Figure("2.80", -5)),
        (0.00099999, Figure("0.00100")),
    ],
)
def test_figures_have_three_digits(value, shown):
    assert figure(value) == shown


def test_shares_are_printed_in_percent_of_the_variance(made):
    found = budgets(made)
    assert found is not None
    for table, estimated in zip(found.tables, made.items.values(), strict=True):
        largest = max(estimated.budgets.values(), key=lambda budget: budget.u_c)
        for line, document in zip(table.lines, largest.inputs, strict=True):
            percent = 100.0 * (document.contribution / largest.u_c) ** 2
            shown = float(line.share.replace("<", "").replace("−", "-"))
            assert shown == pytest.approx(percent, abs=0.1)
