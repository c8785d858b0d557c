"""The result of a calibration: values, uncertainties, and what is missing and why."""

import math
from datetime import date
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import BeforeValidator, Field, PlainSerializer, computed_field, model_validator

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
from schemas.tolerance import Decision, Quantity

# The uncertainty budget of one result: inputs, sensitivities, combined and expanded uncertainty.

EvaluationType = Literal["A", "B"]
Distribution = Literal["normal", "rectangular", "triangular", "arcsine", "t"]
Evaluation = Literal["GUM", "as the specification's example", "Monte Carlo"]


Dof = Annotated[
    float,
    Field(ge=1),
    BeforeValidator(lambda dof: math.inf if dof is None else dof),
    PlainSerializer(
        lambda dof: None if math.isinf(dof) else dof, return_type=float | None, when_used="json"
    ),
]
NotNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]


class BudgetInput(Frozen):
    """One line of a budget: an input quantity and what it does to the result.

    `u` is in the input's own unit, `contribution` = |sensitivity|·u in the result's unit.
    `share` of the variance: cᵢ·u(xᵢ, y)/u²(y), with u(xᵢ, y) = Σⱼ cⱼ·u(xᵢ, xⱼ). Without
    correlation it is (cᵢuᵢ)²/u²(y); with it, half of each covariance term goes to either input,
    so that the shares always add up to 1 and one may be negative (the input compensates
    another). Where the result has no uncertainty every share is 0. A limit of the equipment has
    its `half_width`, in `unit`, and the `source` that states it.
    """

    name: str
    name_zh: str
    name_message: AnyMessage = None
    symbol: str
    kind: EvaluationType
    distribution: Distribution
    u: NotNegative
    unit: str
    dof: Dof = Field(default=math.inf, description="degrees of freedom; null: infinitely many")
    sensitivity: Finite
    contribution: NotNegative
    share: Finite
    half_width: NotNegative | None = None
    source: str | None = None


class Correlation(Frozen):
    """A non-zero correlation coefficient between two inputs, given by their symbols."""

    first: str
    second: str
    r: Annotated[float, Field(ge=-1, le=1)]


class Budget(Frozen):
    """The uncertainty budget of one result, in the result's unit.

    U = k·u_c. `half_width_95`: half width of the interval that holds the result with 95 %
    probability by propagation of the distributions of this linear budget (JCGM 101); null where
    inputs are correlated, or where the budget is not one of distributions. `coverage_interval`
    is stated where it need not be value ± U (Monte Carlo); U is then half its length.
    """

    result: str
    unit: str
    value: Finite
    inputs: tuple[BudgetInput, ...]
    correlations: tuple[Correlation, ...] = ()
    u_c: NotNegative
    dof: Dof = Field(
        default=math.inf, description="effective degrees of freedom; null: infinitely many"
    )
    k: NotNegative
    coverage_probability: Annotated[float, Field(gt=0, lt=1)]
    U: NotNegative
    half_width_95: NotNegative | None = None
    evaluation: Evaluation = "GUM"
    coverage_interval: tuple[Finite, Finite] | None = None


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


# A correction that removes a unit's errors from its readings (format `mimu-correction/1`).

Form = Literal["json", "yaml", "c", "ros", "kalibr", "csv"]
Exported = Literal[Form, "evidence"]
Three = tuple[Finite, Finite, Finite]
Matrix = tuple[Three, Three, Three]
ThreeU = tuple[Finite | None, Finite | None, Finite | None]
MatrixU = tuple[ThreeU, ThreeU, ThreeU]


class Coefficient(Frozen):
    """A vector or a matrix. Rows: output axis; columns: input axis.

    U: expanded uncertainty (with the k of the calibration); null for an element that is taken as
    ideal or computed from others.
    """

    unit: str
    value: Three | Matrix
    U: ThreeU | MatrixU | None = None


class CorrectedUnit(Frozen):
    """The unit whose errors are corrected."""

    manufacturer: str
    model: str
    serial: str


class CorrectionExample(Frozen):
    """A reading before and after correction, to test an implementation of the formulas."""

    gyro: Three = Field(description="reading, rad/s")
    accel: Three = Field(description="reading, m/s2")
    rate: Three = Field(description="corrected, rad/s, Earth's rotation included")
    force: Three = Field(description="corrected specific force, m/s2")


class Correction(Frozen):
    """The correction that a calibration gives, in SI units.

    unit: null for a result whose run is not in the store. model: what a unit reads; correction: the
    steps that undo it, in order. uncertainty: how U was evaluated; covariance: of the elements as
    the calibration states them, in its units. assumed_ideal: elements that it does not provide.
    left_in: physics that the calibration corrected for first, but these formulas do not.
    """

    format: Literal["mimu-correction/1"] = "mimu-correction/1"
    unit: CorrectedUnit | None
    recording_id: str
    run: str
    digest: str
    method: Method
    code_version: str
    gravity_m_s2: Finite = Field(description="local gravity, by which K_a and G were determined")
    model: tuple[str, ...]
    correction: tuple[str, ...]
    coefficients: dict[str, Coefficient]
    uncertainty: UncertaintyKind
    covariance: Covariance | None = None
    assumed_ideal: tuple[str, ...] = ()
    left_in: tuple[str, ...] = ()
    example: CorrectionExample


# What a result rests on, in one file that needs no program of ours (format `mimu-evidence/1`).

Triangle = tuple[tuple[Finite, ...], ...]


class ChannelMeans(Frozen):
    """The means of one channel over the segments that some value takes of it.

    segments: numbers in `segments` of the file. covariance: of these means by noise, drift and
    rounding (type A), the lower triangle, in the square of the unit.
    """

    name: str
    unit: str
    segments: tuple[int, ...]
    means: tuple[Finite, ...]
    covariance: Triangle

    @model_validator(mode="after")
    def _as_many_of_each(self) -> Self:
        count = len(self.segments)
        lengths = [len(row) for row in self.covariance]
        if len(self.means) != count or lengths != list(range(1, count + 1)):
            raise ValueError(f"{self.name}: segments, means and covariance differ in length")
        return self


class Combination(Frozen):
    """Numbers by channel and mean, zeros left out; `mean` counts within its channel."""

    channel: tuple[int, ...] = ()
    mean: tuple[int, ...] = ()
    weight: tuple[Finite, ...] = ()

    @model_validator(mode="after")
    def _as_many_of_each(self) -> Self:
        if not len(self.channel) == len(self.mean) == len(self.weight):
            raise ValueError("channel, mean and weight differ in length")
        return self


class EvidenceSource(Frozen):
    """One error of the equipment: its prior, and what each independent draw does to the means.

    u, half_width: in `unit`. draws: change of each mean, in its channel's unit, per `unit`. scope:
    what shares one draw (run, mounting, face, angle, setting, point). latitude:
    it acts only on values without Earth's rotation.
    """

    symbol: str
    name: Statement
    unit: str
    scope: str
    distribution: Distribution
    u: NotNegative
    half_width: NotNegative | None
    stated_by: str | None
    latitude: bool
    draws: tuple[Combination, ...]


class FurtherLine(Frozen):
    """A line of a budget that is neither of the data nor an error in `sources`, in the value's
    unit.
    """

    symbol: str
    name: Statement
    contribution: NotNegative


class EvidenceValue(Frozen):
    """One value of the result: how it follows from the means, and its U.

    combination: o in value = o·U + constant; null where the value is no such combination (a fit
    that is not linear), and then its budget stands in `lines` whole. constant: Earth's rotation, as
    the unit reads it. scatter: factor on the data's u, above 1 where points scatter more than noise
    and rounding explain. dof: effective degrees of freedom of u. u, U: null where
    the recording does not show an uncertainty. capability: U where the laboratory's own (CMC) is
    larger than k·u, and stated in its place.
    """

    item: str
    element: str
    quantity: Quantity
    unit: str
    value: Finite
    u: NotNegative | None
    U: NotNegative | None
    capability: NotNegative | None = None
    k: NotNegative
    dof: Dof
    data_dof: Dof = Field(description="degrees of freedom of what the data give to u")
    combination: Combination | None
    constant: Finite = 0.0
    scatter: NotNegative = 1.0
    without_earth: bool = False
    lines: tuple[FurtherLine, ...] = ()


class EvidenceFile(Frozen):
    """What every value and U of a result is made of, and what was decided on them.

    coverage: how k was chosen. decision: limits, their rule and the verdicts; null where the file
    goes with no certificate.
    """

    format: Literal["mimu-evidence/1"] = "mimu-evidence/1"
    recording_id: str
    run: str
    digest: str
    method: Method
    procedure: str
    code_version: str
    segments: tuple[str, ...]
    channels: tuple[ChannelMeans, ...]
    sources: tuple[EvidenceSource, ...]
    values: tuple[EvidenceValue, ...]
    covariance: Covariance | None
    coverage: Statement
    decision: Decision | None = None


# How the stated performance of a method was shown: one record for each version of the code.

Evidence = Literal["worked example", "truth recovery", "coverage", "independent program"]
EVIDENCE: tuple[Evidence, ...] = get_args(Evidence)
TARGET_SHARE = (0.93, 0.97)  # of truths inside a 95 % interval, for an item and for each element


class Check(Statement):
    """One piece of evidence: what was compared, the figures, and whether they agree."""

    passed: bool


class Coverage(Frozen):
    """How often intervals contained the truth, over `units` simulated units and their elements.

    inside_95: share within the stated 95 % interval, with its own 95 % confidence interval over the
    units (Wilson). inside_expanded: share within ± U. rms_z: root mean square of error over u.
    """

    units: int = Field(ge=1)
    elements: int = Field(ge=1)
    inside_95: float = Field(ge=0, le=1)
    confidence: tuple[Finite, Finite]
    inside_expanded: float = Field(ge=0, le=1)
    rms_z: Finite
    by_element: dict[str, float] = Field(description="share inside the 95 % interval, of each")

    @property
    def too_short(self) -> dict[str, float]:
        """The elements whose intervals contain the truth too rarely, which an average over the
        item would hide: what is stated of them does not hold.
        """
        return {name: share for name, share in self.by_element.items() if share < TARGET_SHARE[0]}

    @property
    def too_long(self) -> dict[str, float]:
        """The elements whose intervals hold the value more often than stated: U is large enough."""
        return {name: share for name, share in self.by_element.items() if share > TARGET_SHARE[1]}


class ItemValidation(Frozen):
    """The evidence for one item by one method."""

    checks: dict[Evidence, Check]
    coverage: Coverage | None = None

    @property
    def valid(self) -> bool:
        """Whether every kind of evidence was given and none failed."""
        return all(kind in self.checks and self.checks[kind].passed for kind in EVIDENCE)


class MethodValidation(Frozen):
    """The evidence for one method; `fingerprint` identifies the source its numbers come from.

    sources, text: the files of that source within `tasks`, and a hash of their text; while these
    are unchanged, nothing has to be parsed.
    """

    fingerprint: str
    sources: tuple[str, ...] = ()
    text: str = ""
    items: dict[str, ItemValidation]


class ScenarioValidation(Frozen):
    """Coverage under conditions other than those of a run in which everything is in order.

    conditions: by their names; invalid: how many of its sound runs were called invalid.
    """

    conditions: tuple[str, ...]
    units: int = Field(ge=1)
    invalid: int = Field(ge=0)
    items: dict[Method, dict[str, Coverage]]


class ValidationRecord(Frozen):
    """Format `mimu-validation/1`: made by `mimucal validate`."""

    format: Literal["mimu-validation/1"] = "mimu-validation/1"
    made_on: date
    code_version: str
    seed: int
    seconds: Finite
    methods: dict[Method, MethodValidation]
    scenarios: dict[str, ScenarioValidation] = Field(default_factory=dict)
