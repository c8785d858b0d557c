"""A procedure that was chosen, and what it is expected to show."""

from dataclasses import dataclass

from schemas.procedure import Procedure
from tasks.experiment.separation import enough, probability_right


@dataclass(frozen=True)
class Choice:
    """A procedure, its duration in min, and the chi-squared between the two models that are
    hardest to separate, as large as the recording has their effects. bound: the value that decides
    if there is no noise. expected: the least chi-squared between two of the models that compete.
    """

    procedure: Procedure
    minutes: float
    left: float
    bound: float
    expected: float

    @property
    def probability(self) -> float:
        """Of one name, the right one."""
        return probability_right(self.left, self.bound)

    @property
    def needed(self) -> float:
        """Chi-squared from which it decides."""
        return enough(self.bound)

    @property
    def share(self) -> float:
        """Of what it should show; from one on it decides."""
        return self.left / self.needed

    @property
    def is_enough(self) -> bool:
        """Whether it decides."""
        return self.share >= 1.0
