"""A quantity that was measured by hand, with its standard uncertainty."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Measured:
    """value ± u (standard uncertainty) in `unit`."""

    value: float
    u: float
    unit: str

    def agrees(self, other: "Measured") -> bool:
        """Whether both hold the same within 95 % of what they state (k = 2)."""
        return abs(self.value - other.value) <= 2.0 * float(np.hypot(self.u, other.u))

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.value:.4g} ± {self.u:.2g}{unit}"


def batch_mean(values: np.ndarray, batches: int) -> tuple[float, float]:
    """Mean of a course (n,), and its u by the scatter of the means of consecutive batches."""
    means = np.array([batch.mean() for batch in np.array_split(values, batches)])
    return float(values.mean()), float(means.std(ddof=1) / np.sqrt(batches))
