"""A correction that removes a unit's errors from its readings (format `mimu-correction/1`)."""

from typing import Literal

from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.calibration import Covariance, Method, UncertaintyKind

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
