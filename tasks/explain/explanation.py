"""Where model and recording differ, as arrays: the result of `explain`, in words by its report."""

from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import FoundParameter, HeldOut, Verdict
from schemas.recording import Recording
from tasks.words import Sayable, message

UNNAMED = "unnamed"
FITTED = message("explain-model-fitted")


@dataclass(frozen=True)
class Finding:
    """One piece of physics that the model left out.

    effect: its catalogue name, or UNNAMED. channels: indices 0 to 5 of those that show it.
    contribution: (n, 6) rad/s and m/s², what it adds to the readings, at the unit's rows.
    gain: chi-squared that it explains beyond all the rest.
    """

    effect: str
    family: str
    title: Sayable
    equation: str
    source: str
    channels: tuple[int, ...]
    parameters: tuple[FoundParameter, ...]
    contribution: np.ndarray
    gain: float
    delta_bic: float
    held_out_gain: float
    indistinguishable: tuple[str, ...] = ()
    separated_by: Sayable | None = None

    @property
    def follows(self) -> Sayable | None:
        """What an unnamed finding follows, which is all that it is called by."""
        return self.title if self.effect == UNNAMED else None


@dataclass(frozen=True)
class Explanation:
    """Everything that `explain` found in one recording.

    nominal, found: (n, 6) predicted readings at the unit's rows, without and with the findings;
    NaN where the motion is not known. noise: (6,) standard deviation of one sample at rest.
    p_value: of the strongest mismatch, corrected for how many were looked for.
    findings: ordered by evidence. model: what `nominal` is of.
    """

    recording: Recording
    nominal: np.ndarray
    found: np.ndarray
    noise: np.ndarray
    p_value: float
    verdict: Verdict
    held_out: HeldOut
    findings: tuple[Finding, ...]
    remarks: tuple[Sayable, ...] = ()
    model: Sayable = FITTED
