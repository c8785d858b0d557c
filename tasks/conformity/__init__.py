"""The verdict on a unit: its results against the limits of its product model (JCGM 106)."""

from tasks.conformity.decide import decide
from tasks.conformity.deviations import deviations
from tasks.conformity.doubt import Doubt
from tasks.conformity.equipment import expired, smaller_than_stated

__all__ = ["Doubt", "decide", "deviations", "expired", "smaller_than_stated"]
