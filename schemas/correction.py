"""A correction that removes a unit's errors from its readings (format `mimu-correction/1`)."""

from typing import Literal

from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.calibration import Method

Form = Literal["json", "yaml", "c", "ros", "kalibr", "csv"]
Three = tuple[Finite, Finite, Finite]
Matrix = tuple[Three, Three, Three]
ThreeU = tuple[Finite | None, Finite | None, Finite | None]
MatrixU = tuple[ThreeU, ThreeU, ThreeU]


class Coefficient(Frozen):
    """A vector or a matrix. Rows: the axis that reads; columns: the input axis.

    U: expanded uncertainty (k of the calibration); null where an element is taken as ideal or is
    computed from others.
    """

    unit: str
    value: Three | Matrix
    U: ThreeU | MatrixU | None = None


class CorrectedUnit(Frozen):
    """Whose errors the correction takes off."""

    manufacturer: str
    model: str
    serial: str


class CorrectionExample(Frozen):
    """A reading, and what the correction makes of it: for whoever writes the formulas anew."""

    gyro: Three = Field(description="reading, rad/s")
    accel: Three = Field(description="reading, m/s2")
    rate: Three = Field(description="corrected, rad/s, Earth's rotation included")
    force: Three = Field(description="corrected specific force, m/s2")


class Correction(Frozen):
    """The correction that a calibration gives, all in SI units.

    unit: null for a result whose run is not in the store. model: what a unit reads; correction:
    the steps that undo it, in their order. assumed_ideal: elements that the calibration does not
    give. left_in: physics that the calibration took off first, which these formulas do not.
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
    assumed_ideal: tuple[str, ...] = ()
    left_in: tuple[str, ...] = ()
    example: CorrectionExample
