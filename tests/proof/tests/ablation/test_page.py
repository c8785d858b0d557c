"""The table counts what a rule gains and loses."""

from tests.proof.ablation.page import counted, markdown

SHADOWS = {"shadows": "removes less than what stays"}


def _answer(effect: str, group: tuple[str, ...] = (), value: float = 1.0, u: float = 0.1) -> dict:
    return {
        "findings": [
            {
                "effect": effect,
                "group": list(group),
                "indistinguishable_from": [],
                "parameters": [{"name": "seconds", "value": value, "u": u}],
            }
        ]
    }


def _judged(right: tuple[str, ...] = (), wrong: tuple[str, ...] = (), inside: int = 0) -> dict:
    return {"right": right, "wrong": wrong, "inside": inside, "stated": 1}


def _row(label: str, without: dict | None) -> dict:
    return {
        "kind": "rough",
        "label": label,
        "asked": ["shadows"],
        "answer": _answer("time_offset"),
        "judged": _judged(("time_offset",), inside=1),
        "without": {} if without is None else {"shadows": without},
    }


def test_a_rule_that_acts_nowhere_and_one_without_consequence_move_nothing():
    each = counted([_row("1", None), _row("2", {})], "shadows")
    assert (each.asked, each.acted) == (2, 1)
    assert not each.moves


def test_names_gained_and_lost_are_told_apart_by_their_truth():
    other = {"answer": _answer("lever_arm"), "judged": _judged((), ("lever_arm",))}
    each = counted([_row("1", other)], "shadows")
    assert (each.right_gained, each.right_lost) == (0, 1)
    assert (each.wrong_gained, each.wrong_lost) == (1, 0)
    assert each.inside == (1, 0)
    assert each.examples == ("rough 1: +lever_arm!, −time_offset",)


def test_a_name_that_comes_twice_counts_twice():
    both = ("time_offset", "time_offset")
    other = {"answer": _answer("time_offset"), "judged": _judged(both, inside=1)}
    assert counted([_row("1", other)], "shadows").right_gained == 1


def test_groups_and_intervals_that_change_are_counted_though_the_names_stay():
    group = {
        "answer": _answer("time_offset", ("time_offset", "bandwidth")),
        "judged": _judged(("time_offset",)),
    }
    wider = {"answer": _answer("time_offset", u=0.2), "judged": _judged(("time_offset",))}
    hardly = {"answer": _answer("time_offset", u=0.1001), "judged": _judged(("time_offset",))}
    each = counted([_row("1", group), _row("2", wider), _row("3", hardly)], "shadows")
    assert (each.groups, each.intervals) == (1, 1)


def test_a_failure_without_the_rule_is_told():
    text = markdown([_row("1", {"failed": "ValueError: empty"})], SHADOWS)
    assert "fails in 1" in text


def test_a_recording_that_cannot_be_read_is_in_no_row():
    text = markdown([{"kind": "rough", "label": "1", "failed": "Unusable: short"}], SHADOWS)
    assert "0 recordings" in text
    assert "1 could not be read" in text
