"""Golden units: a station that changed is seen against its own history, which it does not move."""

import numpy as np

from tasks.quality.golden import FEWEST, HISTORY, station_check

NOISE = np.random.default_rng(7).standard_normal(200)


def test_a_station_that_shifts_after_its_history_is_out_of_control() -> None:
    values = NOISE[: HISTORY + 10].copy()
    values[HISTORY:] += 4.0
    chart = station_check(values)
    assert chart is not None
    assert chart.broken[:, HISTORY:].any(axis=0).all()
    before = station_check(values[:HISTORY])
    assert before is not None
    assert chart.limits == before.limits  # later values move no limit


def test_a_station_that_stays_as_it_was_rarely_leaves_its_limits() -> None:
    chart = station_check(NOISE)
    assert chart is not None
    assert chart.broken[0].mean() < 0.05


def test_a_short_history_has_no_limits() -> None:
    assert station_check(NOISE[: FEWEST - 1]) is None
    assert station_check(NOISE[:FEWEST]) is not None
