"""The recording that resolves what `explain` left open: the result of `mimucal next`."""

from typing import Any, Literal

from schemas.base import Finite, Frozen
from schemas.text import Statement


class PredictedEvidence(Frozen):
    """What a recording is expected to show of the pair that is told apart worst.

    delta_chi2: by which the competing models differ. probability_right: of one name, the right one.
    """

    delta_chi2: Finite
    probability_right: Finite


class RepeatOfBase(Frozen):
    """What the same recording once more would show."""

    minutes: Finite
    delta_chi2: Finite


class NextRecording(Frozen):
    """decides: the competing effects; one alone against none. procedure: path of the file for
    `acquire --procedure`; null, without steps and minutes, where no recording of this station does.
    """

    format: Literal["mimu-next/1"] = "mimu-next/1"
    decides: tuple[str, ...]
    procedure: str | None
    minutes: Finite | None
    steps: tuple[dict[str, Any], ...]
    predicted: PredictedEvidence
    repeat_of_base: RepeatOfBase
    statement: Statement
