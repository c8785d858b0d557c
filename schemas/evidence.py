"""What a result rests on, in one file that needs no program of ours (format `mimu-evidence/1`)."""

from typing import Literal, Self

from pydantic import Field, model_validator

from schemas.base import Finite, Frozen
from schemas.calibration import Covariance, Method
from schemas.decision import Decision
from schemas.text import Statement
from schemas.tolerance import Quantity
from schemas.uncertainty import Distribution, Dof, NotNegative

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
