"""What a certificate of the joint method claims: a fit of the models, and not the clauses."""

import re

from sample_certificate import calibration, items, printed, tolerance

from tasks.certificate.results import Group, sections
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


def test_the_g_sensitivity_of_a_joint_fit_has_one_column_without_letters() -> None:
    group = groups("joint")["Gyro g-sensitivity"]
    assert len(group.columns) == len(group.matrices) == 1
    assert {row.second for row in group.rows} == {None}
    assert not any(line.startswith("(") for row in group.rows for line in row.limits)
    assert not any("applied to" in en for _, en in group.sentences)
