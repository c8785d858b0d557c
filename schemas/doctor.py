"""Problems of a machine, and their remedies."""

from typing import Literal

from schemas.base import Frozen


class Examined(Frozen):
    """One thing that was examined. remedy: what to do; None if nothing is wrong."""

    what: str
    found: str
    remedy: str | None = None


class Diagnosis(Frozen):
    """Everything that `mimucal doctor` examined, in order."""

    format: Literal["mimu-doctor/1"] = "mimu-doctor/1"
    examined: tuple[Examined, ...]

    @property
    def faults(self) -> tuple[Examined, ...]:
        """The faults that somebody has to put right."""
        return tuple(one for one in self.examined if one.remedy is not None)
