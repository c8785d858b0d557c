"""The reliability method on histories whose answer is known."""

import math
from datetime import UTC, date, datetime, time, timedelta

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from schemas.store import RecallFile, SilentHours
from tasks.reminders import (
    TARGET,
    Interval,
    advise,
    due_date,
    failure_rates,
    is_silent,
    occasion,
    pause,
)

YEAR = 365.0


def history(conforming: int, failed: int = 0, days: float = YEAR) -> list[Interval]:
    return [Interval(days, True)] * conforming + [Interval(days, False)] * failed


@pytest.mark.parametrize("intervals", [1, 5, 60])
def test_without_a_failure_the_bound_is_the_classical_one(intervals):
    """exp(−λ·Σt) = 5 % at the 95 % quantile."""
    (high,) = failure_rates(history(intervals), (0.95,))
    assert high == pytest.approx(-math.log(0.05) / (intervals * YEAR), rel=1e-3)


def test_equal_intervals_give_the_quantiles_of_a_binomial_proportion():
    """With p = exp(−λt), a flat prior on λ is 1/p on p: p is Beta(conforming, failed + 1)."""
    from scipy.stats import beta

    low, middle, high = failure_rates(history(17, 3), (0.05, 0.5, 0.95))
    quantiles = beta(17, 4).ppf([0.95, 0.5, 0.05])
    expected = -np.log(quantiles) / YEAR
    assert [low, middle, high] == pytest.approx(list(expected), rel=2e-3)


def test_the_interval_ends_where_the_target_is_met():
    found = advise(history(190, 10), YEAR)
    assert found.days == pytest.approx(YEAR * math.log(TARGET) / math.log(0.95), rel=0.1)
    assert found.advice == "keep"
    assert found.shortest is not None
    assert found.longest is not None
    assert found.shortest < found.days < found.longest


@pytest.mark.parametrize(
    ("made", "advice"),
    [
        (history(2), "too few"),
        (history(0, 2), "too few"),
        (history(0, 3), "shorten"),
        (history(5, 5), "shorten"),
        (history(5), "keep"),
        (history(100), "may be longer"),
    ],
)
def test_an_interval_is_changed_only_where_the_history_contradicts_it(made, advice):
    assert advise(made, YEAR).advice == advice


def test_the_true_interval_lies_in_the_range_as_often_as_stated():
    """λ drawn from what is assumed of it, then histories by it: 90 %, within 4 σ of 200 draws."""
    draw = np.random.default_rng(5)
    inside = 0
    for rate in draw.uniform(0, 1 / YEAR, 200):
        made = [Interval(YEAR, bool(draw.random() < math.exp(-rate * YEAR))) for _ in range(12)]
        if not any(each.conforming for each in made):
            inside += 1
            continue
        low, high = failure_rates(made, (0.05, 0.95))
        inside += low <= rate <= high
    assert inside / 200 > 0.90 - 4 * 0.0212


# When a reminder is due, when nothing is sent, and when a failed one is tried again.

DUE, ISSUED = date(2027, 11, 20), date(2026, 11, 20)


@pytest.mark.parametrize(
    ("today", "days"),
    [
        (date(2027, 9, 20), None),
        (date(2027, 9, 21), -60),
        (date(2027, 10, 20), -60),
        (date(2027, 10, 21), -30),
        (date(2027, 11, 13), -7),
        (DUE, -7),
        (date(2027, 11, 26), -7),
        (date(2027, 11, 27), 7),
        (date(2027, 12, 20), 30),
        (date(2029, 1, 1), 30),
    ],
)
def test_the_last_occasion_that_has_come_is_the_one(today, days):
    assert occasion(DUE, ISSUED, today) == days


def test_who_just_got_the_certificate_is_not_reminded_of_it():
    issued = DUE - timedelta(days=40)
    assert occasion(DUE, issued, issued) is None
    assert occasion(DUE, issued, DUE - timedelta(days=30)) == -30


@pytest.mark.parametrize(
    ("utc", "silent"),
    [("11:59", False), ("12:00", True), ("20:00", True), ("23:59", True), ("00:00", False)],
)
def test_hours_that_begin_in_the_evening_end_in_the_morning(utc, silent):
    """20:00 to 08:00 in Shanghai is 12:00 to 00:00 UTC."""
    hours = SilentHours(since=time(20), until=time(8), timezone="Asia/Shanghai")
    now = datetime.combine(date(2027, 1, 1), time.fromisoformat(utc), UTC)
    assert is_silent(hours, now) is silent


def test_hours_within_a_day_and_none_at_all():
    noon = datetime(2027, 1, 1, 12, 30, tzinfo=UTC)
    assert is_silent(SilentHours(since=time(12), until=time(13), timezone="UTC"), noon)
    assert not is_silent(SilentHours(since=time(13), until=time(14), timezone="UTC"), noon)
    assert not is_silent(None, noon)


def test_pauses_double_up_to_six_hours():
    minutes = [pause(tries).total_seconds() / 60 for tries in (1, 2, 3, 7, 8, 900)]
    assert minutes == [5, 10, 20, 320, 360, 360]


def test_a_time_zone_that_is_none_and_a_client_twice_are_refused():
    with pytest.raises(ValueError, match="not a time zone"):
        SilentHours(since=time(1), until=time(2), timezone="Mars/Olympus")
    with pytest.raises(ValueError, match="is listed twice"):
        RecallFile.model_validate({"clients": [{"name": "A", "channels": {}}] * 2})


# When a unit comes back.


@pytest.mark.parametrize(
    ("calibrated_on", "months", "due"),
    [
        (date(2026, 11, 21), 12, date(2027, 11, 21)),
        (date(2026, 11, 21), 24, date(2028, 11, 21)),
        (date(2027, 1, 31), 1, date(2027, 2, 28)),
        (date(2028, 1, 31), 1, date(2028, 2, 29)),
        (date(2028, 2, 29), 12, date(2029, 2, 28)),
        (date(2026, 12, 31), 2, date(2027, 2, 28)),
        (date(2026, 12, 15), 1, date(2027, 1, 15)),
    ],
)
def test_due_date_is_the_same_day_or_the_last_of_its_month(calibrated_on, months, due):
    assert due_date(calibrated_on, months) == due


@given(st.dates(date(1990, 1, 1), date(2200, 1, 1)), st.integers(1, 120))
def test_due_date_lies_exactly_the_months_ahead(day, months):
    due = due_date(day, months)
    assert (due.year - day.year) * 12 + due.month - day.month == months
    assert due.day <= day.day
