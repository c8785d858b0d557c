"""When a reminder is due, when nothing is sent, and when a failed one is tried again."""

from datetime import UTC, date, datetime, time, timedelta

import pytest

from schemas.recall import RecallFile, SilentHours
from tasks.reminders.send import is_silent, occasion, pause

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
def test_the_last_occasion_that_has_come_is_the_one(today: date, days: int | None) -> None:
    assert occasion(DUE, ISSUED, today) == days


def test_who_just_got_the_certificate_is_not_reminded_of_it() -> None:
    issued = DUE - timedelta(days=40)
    assert occasion(DUE, issued, issued) is None
    assert occasion(DUE, issued, DUE - timedelta(days=30)) == -30


@pytest.mark.parametrize(
    ("utc", "silent"),
    [("11:59", False), ("12:00", True), ("20:00", True), ("23:59", True), ("00:00", False)],
)
def test_hours_that_begin_in_the_evening_end_in_the_morning(utc: str, silent: bool) -> None:
    """20:00 to 08:00 in Shanghai is 12:00 to 00:00 UTC."""
    hours = SilentHours(since=time(20), until=time(8), timezone="Asia/Shanghai")
    now = datetime.combine(date(2027, 1, 1), time.fromisoformat(utc), UTC)
    assert is_silent(hours, now) is silent


def test_hours_within_a_day_and_none_at_all() -> None:
    noon = datetime(2027, 1, 1, 12, 30, tzinfo=UTC)
    assert is_silent(SilentHours(since=time(12), until=time(13), timezone="UTC"), noon)
    assert not is_silent(SilentHours(since=time(13), until=time(14), timezone="UTC"), noon)
    assert not is_silent(None, noon)


def test_pauses_double_up_to_six_hours() -> None:
    minutes = [pause(tries).total_seconds() / 60 for tries in (1, 2, 3, 7, 8, 900)]
    assert minutes == [5, 10, 20, 320, 360, 360]


def test_a_time_zone_that_is_none_and_a_client_twice_are_refused() -> None:
    with pytest.raises(ValueError, match="not a time zone"):
        SilentHours(since=time(1), until=time(2), timezone="Mars/Olympus")
    with pytest.raises(ValueError, match="is listed twice"):
        RecallFile.model_validate({"clients": [{"name": "A", "channels": {}}] * 2})
