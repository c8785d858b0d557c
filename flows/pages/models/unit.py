"""One unit over the years, and the list of all units."""

from datetime import date
from typing import Literal

from pydantic import Field

from flows.pages.models.run import CertificateShown
from schemas.base import Finite, Frozen
from schemas.text import Statement
from storage.catalogue.units import UnitLine
from tasks.quality.charts import DriftRate

LISTED = 2000
AsMeasured = Literal["found", "left", "invalid"]


class UnitQuestion(Frozen):
    """A unit by its number in the catalogue, else the units with all words of `search`.

    item: whose history is drawn; the first where none is named.
    """

    id: int | None = Field(default=None, ge=1, le=2**31)
    item: str | None = Field(default=None, max_length=100)
    search: str = Field(default="", max_length=200)


class Reading(Frozen):
    """What one run found. state: as found, as left after an adjustment, or of an invalid run."""

    run: str
    day: date
    station: str | None
    state: AsMeasured
    value: Finite | None
    U: Finite | None


class AdjustmentShown(Frozen):
    """The value as found before an adjustment and as left after it, with the runs."""

    found: Reading
    left: Reading


class ElementHistory(Frozen):
    """An element over the years. lower, upper: limits that count now. value, U: of the last valid
    run.
    """

    item: str
    title: Statement
    element: str
    symbol: str
    unit: str
    lower: Finite | None
    upper: Finite | None
    value: Finite | None
    U: Finite | None
    drift: DriftRate | None
    readings: tuple[Reading, ...]
    adjustments: tuple[AdjustmentShown, ...]


class UnitShown(Frozen):
    """A unit, or the list. limits_of: the certificate whose limits stand beside the values;
    limits_by: the document of the model's limits, where no certificate has any. advice: on the
    interval of recalibration; why_no_advice: null where there is one.
    """

    total: int
    units: tuple[UnitLine, ...]
    unit: UnitLine | None = None
    item: str | None = None
    limits_of: str | None = None
    limits_by: str | None = None
    elements: tuple[ElementHistory, ...] = ()
    certificates: tuple[CertificateShown, ...] = ()
    advice: Statement | None = None
    why_no_advice: Statement | None = None
