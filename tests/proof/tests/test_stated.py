"""A claim is right or wrong by what is known by hand, and otherwise not known."""

from typing import Any

from tests.proof.real.facts import Claim
from tests.proof.real.stated import DELAYS, EVERYTHING, KNOWN, Known, judged
from tests.proof.study import bilingual

FACTS = (
    Known("rig", DELAYS, True, "late", "by hand", {"seconds": (0.010, 0.012)}),
    Known("rig", ("axis_wobble",), False, "does not lean", "by hand"),
    Known("rig", ("table_scale",), None, "scale not measured", "by hand"),
    Known("control", EVERYTHING, False, "nothing is left out", "by hand"),
)


def found(effect: str, parameters: tuple[tuple[str, float, float], ...] = (), **more: Any) -> dict:
    listed = [{"name": n, "value": v, "unit": "s", "u": u} for n, v, u in parameters]
    return {"effect": effect, "channels": ["gyro_x"], "parameters": listed, "share": 0.5, **more}


def judgements(recording: str, *findings: dict) -> list[str]:
    declared = judged(recording, {"findings": list(findings)}, FACTS, ())
    return [one.judgement for one in declared]


def test_a_delay_within_what_was_measured_is_right_and_one_beside_it_is_wrong() -> None:
    assert judgements("rig", found("time_offset", (("seconds", 0.011, 1e-5),))) == ["right"]
    assert judgements("rig", found("time_offset", (("seconds", 0.020, 1e-5),))) == ["wrong"]
    assert judgements("rig", found("time_offset", (("seconds", 0.020, 5e-3),))) == ["right"]
    (off,) = judged(
        "rig", {"findings": [found("time_offset", (("seconds", 0.02, 1e-5),))]}, FACTS, ()
    )
    assert off.evidence == "the name is right, its size is not: late (by hand)"


def test_delay_and_low_pass_count_together() -> None:
    both = (found("time_offset", (("seconds", 0.006, 1e-5),)), found("bandwidth"))
    assert judgements("rig", *both) == ["wrong", "wrong"]
    more = found("bandwidth", (("seconds", 0.005, 1e-5),))
    assert judgements("rig", both[0], more) == ["right", "right"]


def test_what_is_known_not_to_be_there_is_wrong() -> None:
    assert judgements("rig", found("axis_wobble")) == ["wrong"]
    assert judgements("control", found("lever_arm")) == ["wrong"]


def test_what_the_hand_does_not_decide_is_not_known() -> None:
    assert judgements("rig", found("table_scale"), found("hysteresis")) == ["not known"] * 2


def test_a_group_counts_by_any_of_its_names() -> None:
    grouped = found("gyro_angular_acceleration", group=("gyro_angular_acceleration", "bandwidth"))
    assert judgements("rig", grouped) == ["right"]


def test_a_finding_without_a_name_is_judged_only_where_it_was_tried() -> None:
    line = found("unnamed", follows={"en": "a line", "zh": "谱线"})
    tried = Claim(
        "rig", bilingual("a line", "谱线"), "false", bilingual("seen by the encoder", "编码器可见"),
        lambda answer: "line" in answer["findings"][0]["follows"],
    )  # fmt: skip
    assert judged("rig", {"findings": [line]}, FACTS, ()) == []
    (one,) = judged("rig", {"findings": [line]}, FACTS, (tried,))
    assert (one.judgement, one.evidence) == ("wrong", "seen by the encoder")


def test_every_known_range_has_a_source_and_rises() -> None:
    for fact in KNOWN:
        assert fact.source
        assert all(low < high for low, high in fact.within.values())
