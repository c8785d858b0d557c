"""When a unit is due for recalibration (clause 9 of JJF 2003-2022 and of JJF 1536-2015)."""

from datetime import date

from dateutil.relativedelta import relativedelta


def due_date(calibrated_on: date, months: int) -> date:
    """The day `months` calendar months after a calibration.

    A day that the month does not have becomes its last day: one month after 31 January is
    28 or 29 February.
    """
    return calibrated_on + relativedelta(months=months)
