"""The page says of each value whether its U holds that by hand, and counts findings."""

from tests.proof.real.hand.measured import Measured
from tests.proof.real.values.by_hand import ByHand
from tests.proof.real.values.page import Explained, markdown


def explained(value: float, u: float, effect: str = "lever_arm", **more: object) -> Explained:
    parameter = {"name": "r_x", "value": value, "unit": "m", "u": u}
    finding = {"effect": effect, "behaviour": "", "refused": None, "parameters": [parameter]}
    answer = {"verdict": "explained", "explained_share": 1.0, "findings": [{**finding, **more}]}
    hand = {("lever_arm", "r_x"): ByHand(Measured(0.1, 2e-4, "m"), "fit")}
    return Explained("rig", answer, hand)


def test_a_value_holds_by_its_own_u_with_that_by_hand_or_not() -> None:
    rows = [explained(*each).rows()[0] for each in ((0.1002, 2e-4), (0.1005, 2e-4), (0.11, 2e-4))]
    assert [row.holds for row in rows] == ["yes", "both", "no"]
    assert rows[0].stated == "100.2 ± 0.4 mm"


def test_what_nobody_measured_does_not_count() -> None:
    page = markdown([explained(0.1, 1e-4), explained(0.1, 1e-4, "size_effect")], "1")
    assert "1 findings have a value by hand: 1 hold by their U alone" in page
    assert "1 stated parameters have none by hand" in page


def test_a_group_is_measured_by_any_of_its_names() -> None:
    assert explained(0.1, 1e-4, "size_effect", group=["lever_arm"]).rows()[0].holds == "yes"


def test_a_refusal_is_told() -> None:
    assert "not explained: too short" in markdown(
        [Explained("short", {"refused": "too short", "findings": []}, {})], "1"
    )


def test_what_others_measured_stands_apart() -> None:
    one = explained(0.1, 1e-4)
    others = {("lever_arm", "r_x"): ByHand(Measured(0.102, 0.0, "m"), "SOURCE.md")}
    page = markdown([Explained(one.name, one.answer, one.hand, others)], "1")
    assert "1 findings have a value by hand: 1 hold by their U alone" in page
    assert "0 of 1 parameters hold by their U alone, 0 with that by hand" in page
