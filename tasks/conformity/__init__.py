"""The verdict on a unit: its results against the limits of its product model (JCGM 106)."""

from tasks.conformity.decide import decide, expired

__all__ = ["decide", "expired"]
