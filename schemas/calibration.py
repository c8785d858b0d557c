"""The result of a calibration: values, uncertainties, and what is missing and why."""

from typing import Any, Literal, Self

from pydantic import Field, computed_field, model_validator

from schemas.base import Finite, Frozen
from schemas.discrepancy import FoundParameter
from schemas.recording import Axis, Kind, Up
from schemas.text import (
    RUN_VERDICTS,
    AnyMessage,
    Message,
    Remark,
    Statement,
    Validity,
    text_in,
    texts_fields,
)
from schemas.uncertainty import Budget

Method = Literal["jjf2003", "joint", "jjf1536"]
OF_STANDARD: dict[str, Method] = {"JJF 2003-2022": "jjf2003", "JJF 1536-2015": "jjf1536"}
OF_NO_STANDARD: Method = "jjf2003"
Elements = dict[str, Finite | None]
UncertaintyKind = Literal["type A", "GUM", "as the specification's example", "Monte Carlo"]


class Item(Frozen):
    """One calibration item. Elements are named by output axis, then input axis.

    `u` is the standard uncertainty, `U` = k·u. An element that the recording does not determine is
    null in every dictionary.
    """

    unit: str
    clause: str
    value: Elements
    u: Elements
    U: Elements
    k: Finite = 2.0
    uncertainty_kind: UncertaintyKind = "type A"
    budgets: dict[str, Budget] = Field(
        default_factory=dict, description="what u of each element is made of"
    )
    readings: tuple[str, ...] = Field(
        default=(),
        description="readings of the specification taken (tasks.specifications.readings)",
    )
    repeatability: Elements | None = Field(
        default=None,
        description="u_A alone, of the elements without U, whose largest error nobody states",
    )
    temperature_degc: Elements | None = Field(
        default=None,
        description="of the unit, at which each element holds: of the segments as they weigh in it",
    )
    value_without_earth_rotation: Elements | None = None
    u_without_earth_rotation: Elements | None = None
    U_without_earth_rotation: Elements | None = None
    value_model: Elements | None = Field(
        default=None, description="the same with the sign of model (2)"
    )


class Covariance(Frozen):
    """Covariance of the elements of a result, type A and type B together.

    elements: as in gyro_scale_factor.x; those without an uncertainty are left out. rows: the lower
    triangle, each row up to its diagonal u², in the product of the units of two items.
    """

    elements: tuple[str, ...]
    rows: tuple[tuple[Finite, ...], ...]

    @model_validator(mode="after")
    def _is_a_triangle(self) -> Self:
        if [len(row) for row in self.rows] != list(range(1, len(self.elements) + 1)):
            raise ValueError("covariance.rows must be the lower triangle: 1, 2, 3 … numbers")
        return self


class Information(Statement):
    """Additional information in the data, beside the results of the clauses, and in sentences what
    it is and how it was found; no decision uses it.

    `about`: the item it refers to, if any. Elements as in `Item`, or channels.
    """

    title: str
    title_zh: str
    title_message: AnyMessage = None
    unit: str
    value: Elements
    u: Elements | None = None
    U: Elements | None = None
    k: Finite = 2.0
    about: str | None = None


class AdoptedTerm(Frozen):
    """Physics outside the standard's model that was found, and corrected for before the clauses."""

    name: str
    title: str
    title_zh: str
    title_message: AnyMessage = None
    parameters: tuple[FoundParameter, ...] = ()


class SegmentUsed(Frozen):
    """A segment as it was used: found or labelled, and which rows its means leave out."""

    name: str
    kind: Kind
    t_start: Finite
    t_end: Finite
    origin: Literal["label", "found"]
    up: Up | None = None
    axis: Axis | None = None
    rate_deg_s: Finite | None = None
    rows: int
    rows_left_out: int = 0
    mean: dict[str, Finite] = Field(
        default_factory=dict, description="of each recorded channel: gyro_* rad/s, accel_* m/s²"
    )
    deviation: dict[str, Finite] = Field(
        default_factory=dict, description="standard deviation of the rows of each channel"
    )


class EnvironmentSeen(Frozen):
    """Smallest and largest air temperature (°C) and humidity (%RH) during the run."""

    temperature_degc: tuple[Finite, Finite] | None = None
    humidity_percent: tuple[Finite, Finite] | None = None


class Calibration(Frozen):
    """The result of one method on one recording (format `mimu-calibration/1`)."""

    format: Literal["mimu-calibration/1"] = "mimu-calibration/1"
    recording_id: str
    run: str
    digest: str
    method: Method
    code_version: str
    procedure: str
    settings: dict[str, Finite | str | None]
    terms: tuple[AdoptedTerm, ...] = Field(
        default=(), description="physics beside models (1) and (2), taken off the readings"
    )
    items: dict[str, Item]
    covariance: Covariance | None = Field(
        default=None, description="of all elements; null where an evaluation has none"
    )
    information: dict[str, Information] = Field(default_factory=dict)
    unavailable: dict[str, str]
    unavailable_zh: dict[str, str] = Field(default_factory=dict)
    unavailable_message: dict[str, Message] = Field(
        default_factory=dict, exclude_if=lambda messages: not messages
    )
    remarks: tuple[Remark, ...] = ()
    segments: tuple[SegmentUsed, ...] = ()
    environment: EnvironmentSeen = EnvironmentSeen()

    @model_validator(mode="before")
    @classmethod
    def _without_computed(cls, document: Any) -> Any:
        """Drops fields of a stored document that are computed from its remarks."""
        if isinstance(document, dict):
            return {n: value for n, value in document.items() if n not in ("warnings", "validity")}
        return document

    @computed_field  # type: ignore[prop-decorator]
    @property
    def warnings(self) -> list[str]:
        """The remarks as plain English sentences."""
        return [remark.en for remark in self.remarks]

    @computed_field  # type: ignore[prop-decorator]
    @property
    def validity(self) -> Validity:
        """The validity of the run: that of its worst remark, which comes first."""
        reasons = [
            remark
            for verdict in ("invalid", "remarks")
            for remark in self.remarks
            if remark.run == verdict
        ]
        verdicts = (remark.run for remark in reasons)
        return Validity(
            verdict=max(verdicts, key=RUN_VERDICTS.index, default="valid"),
            **texts_fields("reasons", tuple(reasons)),
        )

    def why_unavailable(self, item: str) -> Statement | None:
        """Why there is no such item; None where that is not stated."""
        words = [texts.get(item) for texts in (self.unavailable, self.unavailable_zh)]
        return text_in(words, self.unavailable_message.get(item))
