"""What a laboratory states: equipment and its certificates, error limits, its environment."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import ConfigDict, Field, model_validator

from schemas.base import Finite, Frozen, shown

# Measuring equipment of a laboratory: standards, their certificates and their error limits.

# relative, rad or m/s²: equipment with a larger limit cannot calibrate anything
MAX_HALF_WIDTH = 1.0
LimitShape = Literal["normal", "rectangular", "triangular", "arcsine"]
LimitName = Literal[
    "rate",
    "ripple",
    "time_base",
    "level",
    "position",
    "repeatability",
    "axes",
    "fixture",
    "mounting",
    "gravity",
    "latitude",
    "heading",
]
ResultAxes = Literal["mounting plane", "fixture", "unit"]  # which axes results are about


class ErrorBound(Frozen):
    """The error limit of one property of the equipment.

    half_width: relative for rate, ripple and time_base (of the clock that stamps the readings);
    rad for angles, latitude and heading; m/s² for gravity. mounting: of the unit's base in the
    fixture, by the flatness of the surface over the length of the base; without it the results
    hold for the axes of the fixture. level: of the vertical of the table's outermost axis.
    For `normal` it is an expanded uncertainty with k = 2.
    """

    half_width: Annotated[float, Field(gt=0, le=MAX_HALF_WIDTH, allow_inf_nan=False, strict=True)]
    distribution: LimitShape


class EquipmentLimit(ErrorBound):
    """An error limit, and the document that states it."""

    source: str = Field(min_length=1)


# What a certificate states an error of indication for, and over what: °/s, °, or one value.
Argument = Literal["rate", "angle"]
STATED_OVER: Mapping[LimitName, Argument | None] = {
    "rate": "rate",
    "position": "angle",
    "gravity": None,
    "time_base": None,
}
MAX_ERROR = 0.25  # relative, rad or m/s²: deviation, U and drift together stay below MAX_HALF_WIDTH
Uncertainty = Annotated[float, Field(gt=0, le=MAX_ERROR, allow_inf_nan=False)]
Error = Annotated[float, Field(ge=-MAX_ERROR, le=MAX_ERROR, allow_inf_nan=False)]
STEPS = 200  # points of a polynomial's range at which it is checked


class StatedError(Frozen):
    """One row of a certificate: the error of indication at a rate or an angle of a table's axis.

    at: °/s for rate (without a sign: of both directions), ° for position; none for what has one
    value. axis: as the station file names it; none: every axis. deviation: indicated less actual,
    in the unit of the limit (relative to the actual for rate and time_base; rad; m/s²).
    """

    at: Finite | None = None
    axis: str | None = Field(default=None, min_length=1)
    deviation: Error
    U: Uncertainty


class ErrorPolynomial(Frozen):
    """The error of indication as c₀ + c₁·x + c₂·x² …, x in °/s or ° from lowest to highest.

    Its values and U have the unit of a row's deviation.
    """

    axis: str | None = Field(default=None, min_length=1)
    coefficients: tuple[Finite, ...] = Field(min_length=1)
    lowest: Finite
    highest: Finite
    U: Uncertainty

    def at(self, x: float) -> float:
        """Its value."""
        value = 0.0
        for coefficient in reversed(self.coefficients):
            value = value * x + coefficient
        return value

    @model_validator(mode="after")
    def _is_an_error(self) -> Self:
        if not self.lowest < self.highest:
            raise ValueError(f"lowest = {self.lowest:g} is not below highest = {self.highest:g}")
        step = (self.highest - self.lowest) / STEPS
        largest = max(abs(self.at(self.lowest + n * step)) for n in range(STEPS + 1))
        if not largest <= MAX_ERROR:
            raise ValueError(
                f"the polynomial reaches {largest:g} between {self.lowest:g} and {self.highest:g}, "
                f"more than {MAX_ERROR:g}: its coefficients are relative (rad for angles), of °/s "
                "or °"
            )
        return self


class Drift(Frozen):
    """Drift of an error in a year, in its unit; for `normal` with k = 2."""

    per_year: Annotated[float, Field(gt=0, le=0.01, allow_inf_nan=False)]
    distribution: LimitShape


class ErrorFunction(Frozen):
    """What a certificate states of a property: a table with linear interpolation, or polynomials.

    deviation: whether it is corrected, so that U and drift alone count, or budgeted: it then counts
    with U (GUM F.2.4.5). k: of every U. drift: since `calibrated_on`.
    """

    deviation: Literal["corrected", "budgeted"]
    k: Annotated[float, Field(gt=0, le=10, allow_inf_nan=False)] = 2.0
    rows: tuple[StatedError, ...] = ()
    polynomials: tuple[ErrorPolynomial, ...] = ()
    drift: Drift | None = None

    @property
    def axes(self) -> tuple[str | None, ...]:
        """The axes that it is stated for; one None for all of them."""
        stated = [row.axis for row in self.rows] + [part.axis for part in self.polynomials]
        return tuple(dict.fromkeys(stated))

    @model_validator(mode="after")
    def _one_function_of_each_axis(self) -> Self:
        if bool(self.rows) == bool(self.polynomials):
            raise ValueError("give either rows or polynomials, at least one")
        if None in self.axes and len(self.axes) > 1:
            raise ValueError("some entries name an axis and some do not: name one in each, or none")
        twice = [a for a, n in Counter(part.axis for part in self.polynomials).items() if n > 1]
        if twice:
            raise ValueError(f"there are two polynomials of axis {twice[0] or '(every)'}: give one")
        for axis in self.axes:
            _rising([row for row in self.rows if row.axis == axis])
        return self


def _rising(rows: list[StatedError]) -> None:
    for one, other in pairwise(rows):
        if one.at is None or other.at is None:
            raise ValueError("a row of several needs `at`: the rate (°/s) or the angle (°)")
        if not one.at < other.at:
            raise ValueError(
                f"row at = {other.at:g} follows at = {one.at:g}: sort the rows of an axis by `at`, "
                "each once"
            )


class IntermediateCheck(Frozen):
    """An intermediate check of a standard (ISO/IEC 17025:2017, 6.4.10): passed if |result| ≤ limit.

    what: was checked, with unit as the laboratory writes it.
    """

    checked_on: date
    what: str = Field(min_length=1)
    what_zh: str = ""
    result: Finite
    limit: Annotated[float, Field(gt=0, allow_inf_nan=False)]
    unit: str = ""

    @property
    def passed(self) -> bool:
        return abs(self.result) <= self.limit


class MeasurementStandard(Frozen):
    """A measurement standard, as clause 8 h) wants it on the certificate.

    limits: the error limits of its certificate, which go into the budgets and are printed in place
    of `accuracy`. functions: the stated error of rate, position, gravity or time_base with its U,
    as a function of rate or angle. It may be used from `calibrated_on` to `valid_until`. traceable:
    whether its certificate shows an unbroken chain of calibrations to the SI. virtual: whether it
    is one of a simulation; whatever is certified by virtual standards alone says so on each page
    and claims no traceability, and beside a real one it is a standard without any. checks: between
    calibrations; one that failed prevents a pass.
    """

    name: str
    name_zh: str
    serial: str
    accuracy: str
    accuracy_zh: str = ""
    certificate: str
    traceable: bool = True
    virtual: bool = Field(default=False, exclude_if=lambda virtual: not virtual)
    calibrated_on: date | None = None
    valid_until: date | None = None
    limits: dict[LimitName, ErrorBound] = Field(default_factory=dict)
    functions: dict[LimitName, ErrorFunction] = Field(default_factory=dict)
    checks: tuple[IntermediateCheck, ...] = ()

    @model_validator(mode="after")
    def _functions_of_what_has_one(self) -> Self:
        for name, function in self.functions.items():
            if name not in STATED_OVER:
                raise ValueError(
                    f"functions.{name}: a function is of {', '.join(STATED_OVER)}; state {name} in "
                    "limits"
                )
            if name in self.limits:
                raise ValueError(f"{name} stands in limits and in functions: leave one out")
            if function.drift and self.calibrated_on is None:
                raise ValueError(f"functions.{name}.drift counts from calibrated_on: give that day")
            _check_argument(name, function)
        return self

    @model_validator(mode="after")
    def _due_after_it_was_calibrated(self) -> Self:
        if self.calibrated_on and self.valid_until and self.valid_until < self.calibrated_on:
            raise ValueError(
                f"{self.name} ({self.serial}) has valid_until = {self.valid_until} before "
                f"calibrated_on = {self.calibrated_on}"
            )
        return self


def _check_argument(name: LimitName, function: ErrorFunction) -> None:
    over, at = STATED_OVER[name], [row.at for row in function.rows]
    if over is None and (function.polynomials or function.axes != (None,) or at != [None]):
        raise ValueError(f"functions.{name} has one value: give one row without `at` and axis")
    if over is not None and None in at:
        raise ValueError(f"functions.{name}: a row needs `at`, the {over}")
    if over == "rate":
        rates = [*filter(None, at), *(part.lowest for part in function.polynomials)]
        for rate in rates:
            if rate < 0.0:
                raise ValueError(
                    f"functions.rate at {rate:g} °/s: rates are stated without a sign, of both "
                    "directions; where they differ, state the mean with a U that holds both"
                )


class EquipmentFile(Frozen):
    """Measurement standards for the register of the laboratory."""

    format: Literal["mimu-equipment/1"] = "mimu-equipment/1"
    equipment: tuple[MeasurementStandard, ...] = Field(min_length=1)


# The environment variables of the program, which is all of its configuration outside the home.

OWN = "MIMUCAL_"  # a variable with this prefix that is not listed here is a typing error


class Environment(Frozen):
    """Every variable that the program reads; one that is empty counts as not set."""

    model_config = ConfigDict(validate_by_name=True)

    home: Path = Field(
        default=Path("mimucal-data"), alias="MIMUCAL_HOME",
        description="Folder that holds everything; on a line one that all computers share.",
    )  # fmt: skip
    database: str | None = Field(
        default=None, alias="MIMUCAL_DATABASE", repr=False,
        description="The catalogue's PostgreSQL, as postgresql://user@host/name; "
        "unset: SQLite in the home.",
    )  # fmt: skip
    store: str | None = Field(
        default=None, alias="MIMUCAL_STORE",
        description="S3 bucket of the recordings, as s3://BUCKET/PREFIX?endpoint=HOST:PORT&scheme="
        "http (scheme and region where needed); unset: in the home. Keys are named as AWS does.",
    )  # fmt: skip
    station: Path | None = Field(
        default=None, alias="MIMUCAL_STATION",
        description="Folder of the station's own computer for lock, status, stop and the recording "
        "of a run that is going on; unset: the home.",
    )  # fmt: skip
    user: str | None = Field(
        default=None, alias="MIMUCAL_USER",
        description="Person who drafts, checks, issues, amends, withdraws or deletes where --by "
        "names none.",
    )  # fmt: skip
    log: Literal["json", "text"] | None = Field(
        default=None, alias="MIMUCAL_LOG",
        description="json or text: events on standard error, each as a line of JSON or of text; "
        "unset: none, or text where MIMUCAL_LOG_LEVEL is set.",
    )  # fmt: skip
    log_level: Literal["debug", "info", "warning", "error"] | None = Field(
        default=None, alias="MIMUCAL_LOG_LEVEL",
        description="Least level of the events that are written; debug has each command to a "
        "device of the station; unset: info.",
    )  # fmt: skip
    debug: str | None = Field(
        default=None, alias="MIMUCAL_DEBUG",
        description="Set to anything: a failure of the program shows where it happened.",
    )  # fmt: skip
    signing_passphrase: str | None = Field(
        default=None, alias="MIMUCAL_SIGNING_PASSPHRASE", repr=False,
        description="Passphrase or PIN of the key that signs certificates.",
    )  # fmt: skip
    prefect_server: str | None = Field(
        default=None, alias="PREFECT_API_URL",
        description="Prefect server, as http://HOST:4200/api; unset: a command that needs one "
        "starts its own.",
    )  # fmt: skip
    prefect_login: str | None = Field(
        default=None, alias="PREFECT_API_AUTH_STRING", repr=False,
        description="NAME:PASSWORD with which that server is asked (the server's own "
        "PREFECT_SERVER_API_AUTH_STRING).",
    )  # fmt: skip


@dataclass(frozen=True)
class Row:
    """A variable as it is shown: a secret as ***, nothing for one that is not set."""

    variable: str
    value: str | None
    source: Literal["environment", "default"]
    what: str


def in_rows(environment: Environment) -> list[Row]:
    """Each variable with its value and where that comes from."""
    rows = []
    for name, field in Environment.model_fields.items():
        value = getattr(environment, name)
        printed = "***" if value is not None and not field.repr else value
        is_set = name in environment.model_fields_set
        rows.append(
            Row(
                variable=str(field.alias),
                value=None if printed is None else shown(str(printed)),
                source="environment" if is_set else "default",
                what=str(field.description),
            )
        )
    return rows


def variables() -> dict[str, str]:
    """The variable of each field."""
    return {name: str(field.alias) for name, field in Environment.model_fields.items()}


# The limits of a table, of the fixture on it and of the chamber around both.

Positive = Annotated[Finite, Field(gt=0)]


class MotionLimits(Frozen):
    """The most rate and acceleration, and the lowest and highest angle; null: no limit."""

    rate_deg_s: Positive | None = None
    acceleration_deg_s2: Positive | None = None
    angle_deg: tuple[Finite, Finite] | None = None

    @model_validator(mode="after")
    def _low_before_high(self) -> Self:
        if self.angle_deg is not None and self.angle_deg[0] >= self.angle_deg[1]:
            raise ValueError("angle_deg needs the lowest angle first, then the highest")
        return self


class ChamberLimits(Frozen):
    """Between which temperatures a chamber may be set, and how fast its air changes, K/min."""

    temperature_degc: tuple[Finite, Finite]
    rate_k_min: Positive

    @model_validator(mode="after")
    def _low_before_high(self) -> Self:
        if self.temperature_degc[0] >= self.temperature_degc[1]:
            raise ValueError("temperature_degc needs the lowest temperature first")
        return self


class Limits(Frozen):
    """axes: of a table axis, by its name. fixture: of fixture, unit and cable, on every axis.

    chamber: null: its temperature cannot be set.
    """

    axes: dict[str, MotionLimits] = Field(default_factory=dict)
    fixture: MotionLimits = MotionLimits()
    chamber: ChamberLimits | None = None

    def of(self, axis: str) -> tuple[tuple[str, MotionLimits], ...]:
        """Everything that limits an axis, with the name of what is limited."""
        return (f"axis {axis}", self.axes.get(axis, MotionLimits())), ("the fixture", self.fixture)

    def is_endless(self, axis: str) -> bool:
        """Whether an axis may turn on and on."""
        return all(limits.angle_deg is None for _, limits in self.of(axis))
