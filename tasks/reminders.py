"""When a unit is due for recalibration (clause 9 of JJF 2003-2022 and of JJF 1536-2015)."""

from calendar import monthrange
from datetime import date


def due_date(calibrated_on: date, months: int) -> date:
    """The day `months` calendar months after a calibration.

    A day that the month does not have becomes its last day: one month after 31 January is
    28 or 29 February.
    """
    years, month = divmod(calibrated_on.month - 1 + months, 12)
    year, month = calibrated_on.year + years, month + 1
    return date(year, month, min(calibrated_on.day, monthrange(year, month)[1]))
