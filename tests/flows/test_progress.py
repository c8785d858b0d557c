"""What is foretold of long work."""

import pytest

from flows.progress import remaining
from tasks.explain.progress import BEHIND, report_progress


def test_the_time_left_follows_from_what_is_behind() -> None:
    assert remaining(10.0, 0.25) == ", about 30 s left"
    assert remaining(10.0, 0.01) == ""


def test_each_step_of_explain_is_further_than_the_one_before() -> None:
    shares: list[float] = []
    for step in BEHIND:
        for share in (0.0, 0.5):
            report_progress(lambda now, behind: shares.append(behind), step, share)
    assert shares == sorted(set(shares))
    assert shares[0] >= 0.0
    assert shares[-1] < 1.0


def test_a_share_of_a_step_lies_within_it() -> None:
    shares: list[float] = []
    report_progress(lambda now, behind: shares.append(behind), "search", 1.0)
    following = list(BEHIND)[list(BEHIND).index("search") + 1]
    assert shares == [pytest.approx(BEHIND[following])]
