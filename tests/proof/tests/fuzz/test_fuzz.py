"""Some thousand inputs for each parser; the command has a million."""

import pytest

from tests.proof import fuzz
from tests.proof.fuzz import run_all

COUNT = 2000


@pytest.mark.parametrize("kind", fuzz.KINDS, ids=lambda kind: kind.name)
def test_no_frame_is_taken_whose_damage_the_check_sum_shows(kind):
    tally = fuzz.feed(kind, COUNT, seed=2)
    assert tally.fed == COUNT
    assert tally.wrong_though_shown == 0
    assert tally.lost == 0


@pytest.mark.parametrize("feed", fuzz.KINDS.values(), ids=fuzz.KINDS)
def test_answers_are_read_rightly_or_refused(feed):
    assert feed(COUNT, 3).wrong == 0


def test_a_parser_that_takes_damaged_frames_is_found_out(monkeypatch):
    monkeypatch.setattr("tasks.station.drivers.frames._is_good", lambda rows, _: rows[:, 0] > 0)
    little = run_all(400, 3)[0]
    assert little.wrong > 0
