"""The processor time a search may use, after which it keeps what it has."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

# s: ten minutes at 200 Hz may take 30 s in all; motion, events, evidence and consequences need ten.
SEARCH_BUDGET = 20.0


@dataclass(frozen=True)
class TimeBudget:
    """The processor time until which a search continues. clock: s of processor time."""

    until: float
    clock: Callable[[], float] = time.process_time

    @classmethod
    def of(cls, seconds: float, clock: Callable[[], float] = time.process_time) -> "TimeBudget":
        """So many seconds from now on."""
        return cls(clock() + seconds, clock)

    @property
    def spent(self) -> bool:
        return self.clock() >= self.until


UNLIMITED = TimeBudget(math.inf)
