"""How the stated performance of a method was shown: one record for each version of the code."""

from datetime import date
from typing import Literal, get_args

from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.calibration import Method
from schemas.text import Statement

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
        """Those whose intervals contain it more often than stated: it holds, with room to spare."""
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
