"""The budgets on request: the lines of the largest element, and the sums of every element."""

import re
from functools import cache

import pypdfium2
import pytest
from sample_certificate import certificate

from schemas.calibration import Calibration
from schemas.certificate import Certificate
from tasks.calibrate.calibrate import calibrate
from tasks.calibrate.evaluation import evaluation_for
from tasks.certificate.budgets import Figure, budgets, figure
from tasks.certificate.pdf import render
from tasks.specifications.jjf2003 import JJF2003

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


@pytest.mark.rehearsal
def test_the_budgets_are_printed_only_where_they_were_asked_for(made) -> None:
    without, asked = (text_of(render(printed(made, wanted))) for wanted in (False, True))
    assert "Uncertainty budgets" not in without
    for words in (
        "不确定度评定 Uncertainty budgets",
        "repeatability",
        "squareness of axes",
        "rectangular",
        "Sensitivity",
        "Share %",
        "Effective dof",
        "95 % half width",
    ):
        assert words in asked


def test_every_item_has_the_lines_of_its_most_uncertain_element(made) -> None:
    found = budgets(made)
    assert found is not None
    assert len(found.tables) == len(made.items)
    for table, item in zip(found.tables, made.items.values(), strict=True):
        largest = max(item.budgets.values(), key=lambda budget: budget.u_c)
        assert len(table.lines) == len(largest.inputs)
        assert [line.u for line in table.lines] == [figure(each.u) for each in largest.inputs]
        assert table.of in {element.name for element in table.elements}
        assert len(table.elements) == len(item.budgets)
        assert table.k == f"{item.k:g}"


def test_type_a_and_type_b_make_up_the_combined_uncertainty(made) -> None:
    found = budgets(made)
    assert found is not None

    def size(shown: Figure) -> float:
        return float(shown.digits) * 10.0**shown.exponent

    for table in found.tables:
        for element in table.elements:
            together = (size(element.of_data) ** 2 + size(element.of_equipment) ** 2) ** 0.5
            assert size(element.u_c) == pytest.approx(together, rel=0.01)


def test_as_the_example_it_is_said_how_it_was_done(ideal_run) -> None:
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
def test_figures_have_three_digits(value: float, shown: Figure) -> None:
    assert figure(value) == shown


def test_shares_are_printed_in_percent_of_the_variance(made) -> None:
    found = budgets(made)
    assert found is not None
    for table, item in zip(found.tables, made.items.values(), strict=True):
        largest = max(item.budgets.values(), key=lambda budget: budget.u_c)
        for line, document in zip(table.lines, largest.inputs, strict=True):
            percent = 100.0 * (document.contribution / largest.u_c) ** 2
            shown = float(line.share.replace("<", "").replace("−", "-"))
            assert shown == pytest.approx(percent, abs=0.1)
