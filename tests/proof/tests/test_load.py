"""How a demonstration on a busy computer is judged."""

import pytest

from tests.proof.load import LoadedRun, as_markdown, outcome_of, summary, worst_in_U

TRUTH = {"Kg": [[1.01, 0.002, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "Ka": [[1.0] * 3] * 3}


@pytest.mark.parametrize(
    ("validity", "verdict", "worst", "outcome"),
    [
        ("valid", "pass", 0.8, "whole"),
        ("remarks", "inconclusive", 0.8, "whole"),
        ("valid", "inconclusive", 0.8, "undecided"),
        ("valid", "fail", 0.8, "false"),
        ("valid", "pass", 2.5, "false"),
        ("invalid", "inconclusive", 900.0, "invalid"),
        ("invalid", "pass", 0.8, "false"),
        ("invalid", "fail", 0.8, "false"),
    ],
)
def test_a_run_that_counts_is_right_and_an_invalid_one_has_no_verdict(
    validity: str, verdict: str, worst: float, outcome: str
) -> None:
    assert outcome_of(validity, verdict, worst) == outcome


def test_the_largest_error_is_counted_in_its_own_uncertainty() -> None:
    items = {
        "gyro_scale_factor": {"value": {"x": 1.012, "y": None}, "U": {"x": 0.001, "y": None}},
        "gyro_cross_coupling": {"value": {"xy": 0.0}, "U": {"xy": 0.0005}},
    }
    assert worst_in_U(items, TRUTH) == pytest.approx(4.0)


def test_a_run_that_stopped_does_not_hold_and_the_page_has_its_sentence() -> None:
    found = [
        LoadedRun(1, "whole", "valid", "pass", 0.3, 8.0, 90.0, ""),
        LoadedRun(2, "stopped", "", "", 0.0, 8.0, 20.0, "the unit | was silent"),
    ]
    assert [one.holds for one in found] == [True, False]
    assert summary(found).startswith("2 demonstrations with every core busy: 1 whole")
    assert "the unit / was silent" in as_markdown(found)
