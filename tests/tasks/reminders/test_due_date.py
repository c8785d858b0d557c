"""When a unit comes back."""

from datetime import date

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tasks.reminders import due_date


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
def test_due_date_is_the_same_day_or_the_last_of_its_month(
    calibrated_on: date, months: int, due: date
) -> None:
    assert due_date(calibrated_on, months) == due


@given(st.dates(date(1990, 1, 1), date(2200, 1, 1)), st.integers(1, 120))
def test_due_date_lies_exactly_the_months_ahead(day: date, months: int) -> None:
    due = due_date(day, months)
    assert (due.year - day.year) * 12 + due.month - day.month == months
    assert due.day <= day.day
