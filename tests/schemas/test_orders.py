"""Orders: the same model from the command line, from JSON and from a schedule."""

from datetime import date

import pytest

from schemas.base import Unusable
from schemas.orders import CalibrateOrder, CertifyOrder, ProduceOrder, WithdrawOrder, order_of


def test_terms_as_text_are_names_each_once():
    order = CalibrateOrder.model_validate(
        {"run": "r1", "terms": " lever_arm,earth_rotation,lever_arm"}
    )
    assert order.terms == ("earth_rotation", "lever_arm")
    assert CalibrateOrder(run="r1", terms=" , ").terms == ()
    assert CalibrateOrder(run="r1").terms is None


def test_an_empty_reason_is_refused_by_the_name_of_its_option():
    with pytest.raises(Unusable, match=r"^--why is empty: give a text\.$"):
        order_of(WithdrawOrder, certificate="C-1", by="Ann", why="")


def test_order_survives_json():
    order = CertifyOrder(run="r1", method="jjf2003", calibrated_on=date(2026, 1, 2), budget=True)
    assert CertifyOrder.model_validate_json(order.model_dump_json()) == order


@pytest.mark.parametrize(
    ("fields", "says"),
    [
        ({"method": "guess"}, r"--method guess: choose one of jjf2003, joint, jjf1536"),
        ({"uncertainty": "guess"}, r"--uncertainty guess: choose one of gum, montecarlo, example"),
        ({"terms": "a", "method": "joint"}, r"leave --method joint or --terms out"),
        ({"terms": "a", "uncertainty": "example"}, r"leave --uncertainty example out"),
    ],
)
def test_what_cannot_be_ordered_is_one_sentence(fields, says):
    with pytest.raises(Unusable, match=says) as refusal:
        order_of(CalibrateOrder, run="r1", **fields)
    assert "\n" not in str(refusal.value)


def test_production_hands_down_all_that_its_certificate_needs():
    order = ProduceOrder(
        station="station.json", home="h", tolerance="t", laboratory="l", client_order="o",
        calibrated_on=date(2026, 1, 2), budget=True,
    )  # fmt: skip
    certify = order.certify("r1")
    assert certify == CertifyOrder(
        run="r1", home="h", tolerance="t", laboratory="l", client_order="o",
        calibrated_on=date(2026, 1, 2), budget=True,
    )  # fmt: skip
