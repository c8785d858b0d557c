"""The judge of stops: what it counts, and a few stops of each kind."""

from pathlib import Path

import pytest

from tests.proof.stops.run import as_markdown, run_all, summary
from tests.proof.stops.stop import Pressed


def test_the_page_says_how_many_went_wrong_and_has_a_row_for_each() -> None:
    pressed = [
        Pressed(1, "command", "home", 1.0, True, 1.25, 1.5, (), True),
        Pressed(2, "kill -9", "nothing", 5.0, True, 5.5, 0.0, (), False),
        Pressed(3, "Ctrl-C", "database", 5.0, False, 0.0, 0.0, ("no recording is left",)),
    ]
    assert "3 stops at random moments, 2 of them with the table turning: 2 wrong" in summary(
        pressed
    )
    assert "at most 1.25 s after the press, and at most 5.50 s after" in summary(pressed)
    assert "1 of the 2 runs" in summary(pressed)
    assert "| 1 | command | home | 1 | yes | 1.25 | 1.50 | yes |  |" in as_markdown(pressed)


@pytest.mark.rehearsal
@pytest.mark.real_time
def test_a_few_stops_leave_a_table_at_rest_and_nothing_running(tmp_path: Path) -> None:
    pressed = run_all(tmp_path, 8, lambda done, count: None)
    assert [each.faults for each in pressed] == [()] * 8
    assert any(each.turning for each in pressed)
