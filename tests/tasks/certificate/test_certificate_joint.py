"""What a certificate of the joint method claims: a fit of the models, and not the clauses."""

import re

from sample_certificate import calibration, items, printed, tolerance

from tasks.certificate.results import Group, sections
from tasks.certificate.statements import basis
from tasks.conformity import decide
from tasks.specifications.joint.remarks import CLAUSES
from tasks.specifications.register import SPECIFICATIONS


def groups(method: str) -> dict[str, Group]:
    made = calibration(
        method=method,
        items={
            name: item.model_copy(
                update={"clause": f"{CLAUSES[name.partition('_')[0]]}, joint method"}
            )
            for name, item in items().items()
        },
    )
    found = printed(sections(made, decide(made, tolerance()), SPECIFICATIONS[method]))
    return {group.title[1]: group for section in found for group in section.groups}


def test_no_value_of_a_joint_fit_is_said_to_be_by_an_equation_of_the_clauses() -> None:
    headings = [
        heading
        for name in ("Gyro g-sensitivity", "Accelerometer rate sensitivity")
        for column in groups("joint")[name].columns
        for heading in column
    ]
    assert "Value" in headings  # of the g-sensitivity, which the fit gives once
    assert not any(re.search(r"by eq\.|^\(a\) 式\(7\)", heading) for heading in headings)
    assert "(a) by eq. (7)" in dict(groups("jjf2003")["Gyro g-sensitivity"].columns).values()


def test_the_clause_of_a_joint_fit_is_named_in_each_language() -> None:
    assert groups("joint")["Gyro bias"].clause == (
        "5.1 式(1)（联合法）",
        "5.1 eq. (1), joint method",
    )


def test_the_basis_says_that_it_is_not_the_computation_of_the_clauses() -> None:
    zh, en = printed(basis(calibration(method="joint"), SPECIFICATIONS["joint"], False))[0]
    assert "not the computation of its clauses" in en
    assert "非该规范条款规定的计算方法" in zh


def test_the_g_sensitivity_of_a_joint_fit_has_one_column_without_letters() -> None:
    group = groups("joint")["Gyro g-sensitivity"]
    assert len(group.columns) == len(group.matrices) == 1
    assert {row.second for row in group.rows} == {None}
    assert not any(line.startswith("(") for row in group.rows for line in row.limits)
    assert not any("applied to" in en for _, en in group.sentences)


def test_the_rate_sensitivity_of_a_joint_fit_is_no_difference_of_rest_and_turning() -> None:
    text = " ".join(en for _, en in groups("joint")["Accelerometer rate sensitivity"].sentences)
    assert "rest minus turning" not in text
    assert "(a) is its negative" in text
