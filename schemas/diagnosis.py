"""What is wrong with a machine, and how to put it right."""

from typing import Literal

from schemas.base import Frozen


class Examined(Frozen):
    """One thing that was looked at. remedy: what to do; None where nothing is wrong."""

    what: str
    found: str
    remedy: str | None = None


class Diagnosis(Frozen):
    """All that `mimucal doctor` looked at, in order."""

    format: Literal["mimu-doctor/1"] = "mimu-doctor/1"
    examined: tuple[Examined, ...]

    @property
    def faults(self) -> tuple[Examined, ...]:
        """What needs somebody to do something."""
        return tuple(one for one in self.examined if one.remedy is not None)
