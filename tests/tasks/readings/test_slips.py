"""Losses that a logger closed are counted, and nothing is lost in recordings that are whole."""

import numpy as np
import pytest
from logged import Unit, numbered, procedure, read, recorded, swinging

from tasks.explain.events.stamps import find_lost_samples
from tasks.explain.inputs.blocks import full_rate

CASES = [
    (100.0, False, ((70.0, 7), (190.0, 7))),
    (200.0, False, ((33.5, 8), (91.5, 6))),
    (125.0, False, ((68.4, 11),)),
    (50.0, False, ((40.0, 1), (140.0, 2))),
    (250.0, False, ((58.2, 12), (120.4, 13), (198.3, 13), (222.4, 9), (231.9, 10))),
    (25.0, True, ((42.0, 14), (151.4, 4))),
    (100.0, True, ((30.0, 20), (75.0, 1), (118.0, 3))),
    (400.0, True, ((55.0, 5),)),
    (100.0, True, tuple((25.0 + 17.0 * k, 1 + 3 * k % 20) for k in range(12))),
    (100.0, False, tuple((25.0 + 20.0 * k, 20 - k) for k in range(12))),
]


def _losses(rate: float, swings: bool, gaps: tuple[tuple[float, int], ...], seed: int):
    course, rng = swinging() if swings else procedure(), np.random.default_rng(seed)
    at = np.arange(0.0, course.until, 1.0 / rate)
    rows, stamps = numbered(at, gaps)
    full = full_rate(
        recorded("numbered", course, stamps, read(course, at[rows] - 2e-3, Unit(), rng))
    )
    return find_lost_samples(full.readings, full.motion, np.zeros(full.readings.shape, bool))


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, marks=[] if case in (0, 6, 8) else pytest.mark.rehearsal)
        for case in range(len(CASES))
    ],
)
def test_closed_gaps_are_counted_and_placed(case):
    rate, swings, gaps = CASES[case]
    found = _losses(rate, swings, gaps, case)
    assert found is not None
    assert found.lost.sum() == sum(lost for _, lost in gaps)
    already = np.cumsum([0, *(lost for _, lost in gaps)])[:-1]
    for (when, _), before in zip(gaps, already, strict=True):
        # At rest, or at a held rate, no reading tells the moment.
        assert np.abs(found.times - (when - before / rate)).min() < (5.0 if swings else 12.0)


@pytest.mark.parametrize("swings", [False, True])
@pytest.mark.parametrize(
    "rate",
    [
        25.0,
        100.0,
        *(pytest.param(one, marks=pytest.mark.rehearsal) for one in (50.0, 200.0, 400.0)),
    ],
)
def test_whole_recordings_lost_nothing(rate, *, swings):
    assert _losses(rate, swings, (), round(rate)) is None
