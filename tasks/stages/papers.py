"""What a certificate needs beside the result."""

from dataclasses import dataclass
from datetime import date

from schemas.certificate import Laboratory, Order
from schemas.tolerance import Tolerance


@dataclass(frozen=True)
class Papers:
    """Limits, letterhead and order; None where the home has to say, or nobody.

    calibrated_on: the day of calibration, for a recording that does not say when it was made.
    budget: whether the certificate prints the uncertainty budgets.
    """

    tolerance: Tolerance | None = None
    laboratory: Laboratory | None = None
    order: Order | None = None
    calibrated_on: date | None = None
    budget: bool = False
