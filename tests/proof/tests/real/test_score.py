"""Scores: what was hidden must be new, named, of its size, and alone."""

from typing import Any

import pytest

from tests.proof.real.hidden import NOT_HIDDEN, Hidden, Score, as_data, hidden_cases, scored
from tests.proof.real.hide import TRANSFORMATIONS, Size
from tests.proof.real.run import cells
from tests.proof.study import bilingual


def answer(*findings: tuple[str, str, float, float]) -> dict[str, Any]:
    return {
        "seconds": 1.0,
        "findings": [
            {"effect": e, "channels": [], "parameters": [{"name": n, "value": v, "u": u}]}
            for e, n, v, u in findings
        ],
    }


LOW_PASS = ("bandwidth", "time_constant", 0.007, 1e-4)
SHIFT = Hidden("shaft", "time_offset", Size(0.010, "s"))


def score(case: Hidden, after: dict[str, Any]) -> Score:
    return scored(case, after, answer(LOW_PASS), None)


@pytest.mark.parametrize(
    ("after", "outcome"),
    [
        (answer(LOW_PASS, ("time_offset", "seconds", 0.010, 1e-4)), "found, value right"),
        (answer(("time_offset", "seconds", 0.017, 2e-4)), "found, value right"),
        (answer(LOW_PASS, ("time_offset", "seconds", 0.014, 1e-4)), "found, value off"),
        (answer(("bandwidth", "time_constant", 0.017, 1e-4)), "missed"),
        (answer(LOW_PASS, ("unnamed", "frequency", 3.0, 0.1)), "missed"),
        (
            answer(("time_offset", "seconds", 0.017, 2e-4), ("clock_skew", "share", 1e-5, 1e-6)),
            "a wrong name",
        ),
        ({"seconds": 1.0, "failed": "ValueError: x"}, "explain failed"),
    ],
)
def test_shift_counts_by_the_change_of_all_delay(after: dict[str, Any], outcome: str) -> None:
    assert score(SHIFT, after).outcome == outcome


def test_nothing_new_is_right_where_nothing_is_hidden_or_seen() -> None:
    zero = Hidden("shaft", "time_offset", Size(0.0, "s"))
    unseen = Hidden("shaft", "axis_tilt", Size(0.01, "rad"), bilingual("absorbed", "被吸收"))
    named = answer(LOW_PASS, ("axis_tilt", "east", 0.01, 1e-3))
    for case in (zero, unseen):
        assert score(case, answer(LOW_PASS)).outcome == "rightly nothing new"
        assert score(case, named).outcome == "a wrong name"


def test_lost_samples_are_counted_together() -> None:
    case = Hidden("shaft", "dropped_samples", Size(5.0, "1", at=40.0))
    found = score(case, answer(("dropped_samples", "lost_1", 5.0, 0.1)))
    assert found.outcome == "found, value right"
    assert as_data(found)["stated"]["value"] == 5.0
    assert "5 at 40 s" in cells(found)


def test_every_transformation_is_hidden_in_three_sizes_and_zero() -> None:
    cases = hidden_cases(1)
    for name in TRANSFORMATIONS:
        sizes = [c.size.value for c in cases if c.name == name and c.recording.startswith("enc")]
        assert len(sizes) == 4
        assert sizes[0] == 0.0 < min(sizes[1:])
    assert all(why.en and why.zh for *_, why in NOT_HIDDEN)
    assert hidden_cases(1) == cases != hidden_cases(2)
