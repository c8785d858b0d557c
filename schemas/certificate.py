"""A certificate: who, for whom, with what, and the result it prints (clause 8 of JJF 2003)."""

from datetime import date
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from schemas.base import Frozen
from schemas.calibration import Calibration
from schemas.decision import Decision
from schemas.recording import Manifest
from schemas.station import LimitShape, MeasurementStandard

MAX_HALF_WIDTH = 1.0  # relative, rad or m/s²: equipment that may be further off calibrates nothing
State = Literal["draft", "checked", "issued", "amended", "withdrawn"]
LimitName = Literal[
    "rate", "ripple", "position", "repeatability", "axes", "fixture", "gravity", "latitude"
]


class Party(Frozen):
    """A laboratory or a client."""

    name: str
    name_zh: str
    address: str
    address_zh: str


class EquipmentLimit(Frozen):
    """How far one property of a laboratory's equipment may be off, and which paper says so.

    half_width: relative for rate and ripple, rad for angles and latitude, m/s² for gravity.
    For «normal» it is an expanded uncertainty with k = 2.
    """

    half_width: Annotated[float, Field(gt=0, le=MAX_HALF_WIDTH, allow_inf_nan=False, strict=True)]
    distribution: LimitShape
    source: str = Field(min_length=1)


class Laboratory(Frozen):
    """Clause 8 b), h), k), l): the laboratory, its standards, who signs (a file in the home).

    limits: what its equipment may be off by, in the place of Table 1 of the specification.
    latitude_deg: of its own place, against which that of each recording is held.
    """

    format: Literal["mimu-laboratory/1"] = "mimu-laboratory/1"
    party: Party
    certificate_prefix: str = "MIMU"
    equipment: tuple[MeasurementStandard, ...] = ()
    limits: dict[LimitName, EquipmentLimit] = Field(default_factory=dict)
    latitude_deg: float | None = Field(default=None, ge=-90, le=90)
    operator: str | None = None
    checker: str | None = None
    issuer: str | None = None
    issuer_title: str | None = None
    issuer_title_zh: str | None = None


class Order(Frozen):
    """Clause 8 e), g) and 9: the client, when the unit came, how often it comes back.

    calibrated_on: for a recording that does not say when it was made. interval_months: null
    leaves it to the specification (12 months in JJF 2003, 24 in JJF 1536).
    """

    format: Literal["mimu-order/1"] = "mimu-order/1"
    client: Party
    received: date
    calibrated_on: date | None = None
    interval_months: int | None = Field(default=None, gt=0, le=120)


class AsFound(Frozen):
    """The same unit before it was adjusted: its result, and the verdict by the same limits."""

    calibrated_on: date | None
    calibration: Calibration
    decision: Decision


class Certificate(Frozen):
    """Everything the certificate prints; the PDF is made from this and nothing else.

    calibrated_on: null where nothing gives the day; `due` then counts from `issued_on`.
    as_found: where the unit was adjusted, and calibration and decision are those as left.
    budgets: whether the uncertainty budgets of the calibration are printed. validation: which
    record validates the estimation, and how many items (English, Chinese).
    """

    format: Literal["mimu-certificate-record/1"] = "mimu-certificate-record/1"
    number: str
    state: State
    calibrated_on: date | None
    issued_on: date
    due: date
    laboratory: Laboratory | None
    order: Order | None
    manifest: Manifest
    calibration: Calibration
    decision: Decision
    as_found: AsFound | None = None
    budgets: bool = False
    validation: tuple[str, str] | None = None

    @model_validator(mode="after")
    def _received_before_it_was_calibrated(self) -> Self:
        day, order = self.calibrated_on, self.order
        if day and order and order.received > day:
            raise ValueError(
                f"the order says received = {order.received}, which is after the calibration of "
                f"{day}: correct the order"
            )
        return self
