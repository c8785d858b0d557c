"""The register of measurement standards: which certificate of each counts on a day."""

from datetime import date

import pytest

from schemas.base import Unusable
from schemas.laboratory import IntermediateCheck, MeasurementStandard
from storage.catalogue import audit_trail, equipment
from storage.home import Home

FIRST, SECOND = date(2025, 3, 1), date(2026, 3, 1)


def standard(certificate: str = "C-1", **changes: object) -> MeasurementStandard:
    given: dict[str, object] = {
        "name": "Turntable", "name_zh": "转台", "serial": "T-1", "accuracy": "",
        "certificate": certificate, "calibrated_on": FIRST, "valid_until": date(2026, 2, 28),
        "limits": {"rate": {"half_width": 2e-5, "distribution": "normal"}},
    }  # fmt: skip
    return MeasurementStandard.model_validate(given | changes)


RENEWED = standard("C-2", calibrated_on=SECOND, valid_until=date(2027, 2, 28))


@pytest.fixture
def home(fresh) -> Home:
    equipment.add([standard()], fresh, "Li")
    return fresh


def test_a_standard_comes_back_with_its_limits(home):
    assert equipment.register(home) == [standard()]


@pytest.mark.parametrize(
    ("day", "certificate"),
    [(date(2025, 1, 1), "C-1"), (FIRST, "C-1"), (date(2026, 2, 28), "C-1"), (SECOND, "C-2"),
     (date(2030, 1, 1), "C-2"), (None, "C-2")],
)  # fmt: skip
def test_the_certificate_that_counts_is_that_of_the_day(home, day, certificate):
    equipment.renew([RENEWED], home, "Li")
    assert equipment.on_day(home, day)["T-1"].certificate == certificate


def test_past_due_is_who_had_no_valid_certificate_on_the_day(either):
    equipment.add([standard()], either, "Li")
    assert equipment.past_due(either, date(2026, 2, 28)) == []
    assert equipment.past_due(either, SECOND) == [standard()]
    equipment.renew([RENEWED], either, "Li")
    assert equipment.register(either) == [standard(), RENEWED]
    assert equipment.past_due(either, SECOND) == []
    assert [each.certificate for each in equipment.past_due(either, date(2027, 3, 1))] == ["C-2"]


def test_one_that_is_there_is_not_added_again_and_nothing_beside_it(home):
    with pytest.raises(Unusable, match="is already in the register, with certificate C-1"):
        equipment.add([standard(serial="T-2"), standard("C-3")], home, "Li")
    assert [each.serial for each in equipment.register(home)] == ["T-1"]


@pytest.mark.parametrize(
    ("given", "says"),
    [
        (standard(serial="T-9"), "T-9.* is not in the register"),
        (standard(), "certificate C-1 .* is already in the register"),
        (standard("C-2", calibrated_on=None), "has no calibrated_on"),
    ],
)
def test_what_renews_nothing_is_refused(home, given, says):
    with pytest.raises(Unusable, match=says):
        equipment.renew([given], home, "Li")


def test_the_trail_tells_who_changed_the_register(home):
    equipment.renew([RENEWED], home, "Wang")
    assert [(each.person, each.action, each.subject) for each in audit_trail.entries(home)] == [
        ("Li", "add equipment", "T-1"), ("Wang", "renew equipment", "T-1"),
    ]  # fmt: skip


def test_a_check_stands_beside_the_certificate_of_its_day_until_that_is_renewed(home):
    equipment.renew([RENEWED], home, "Li")
    check = IntermediateCheck(checked_on=date(2025, 9, 1), what="rate", result=2e-5, limit=1e-5)
    assert equipment.add_check("T-1", check, home, "Wang").certificate == "C-1"
    assert equipment.on_day(home, date(2025, 6, 1))["T-1"].checks == (check,)
    assert equipment.on_day(home, SECOND)["T-1"].checks == ()
    *_, last = audit_trail.entries(home)
    assert (last.person, last.action, last.subject) == ("Wang", "check equipment", "T-1")
