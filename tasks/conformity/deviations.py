"""Conditions of the specification that were not met, or were not checked."""

from collections.abc import Iterable
from dataclasses import dataclass

from schemas.calibration import Calibration
from schemas.certificate import ConditionName
from schemas.configuration import Configuration
from schemas.recording import AXES, Standard
from tasks.specifications.register import SPECIFICATIONS
from tasks.words import Message, Sayable, message
from tasks.words.rounding import as_given
from tasks.words.typography import clause

# Where a specification asks for the largest input rate; JJF 1536 asks for rates within the range.
LARGEST_RATE: dict[Standard, str] = {"JJF 2003-2022": "JJF 2003-2022, 7.2.1.1 c)"}
FULL_SCALE = 0.999  # of the unit's largest input rate counts as that rate
NOT_RECORDED = {"environment_not_recorded", "environment_in_part"}  # remarks on the air


@dataclass(frozen=True)
class Deviation:
    """A condition by its name, what is missing, and whether the client waives it."""

    name: ConditionName
    sentence: Sayable
    waived: bool

    @property
    def printed(self) -> Message:
        """The deviation as printed on the certificate, and among the reasons if it prevents a
        pass.
        """
        kind = "waived" if self.waived else "open"
        condition = message(f"conformity-waivable.{self.name.replace('_', '-')}")
        return message(f"conformity-deviation.{kind}", name=condition, sentence=self.sentence)


def deviations(
    calibration: Calibration, configuration: Configuration, waived: Iterable[ConditionName] = ()
) -> tuple[Deviation, ...]:
    """Every condition that was not shown to be met, in the order of the specification."""
    waived = set(waived)
    found: list[tuple[ConditionName, Sayable]] = []
    rates = largest_rate(calibration, configuration)
    if rates is not None and not rates.included:
        found.append(("largest_rate", rates.sentence))
    found += [
        ("environment", remark) for remark in calibration.remarks if remark.code in NOT_RECORDED
    ]
    return tuple(Deviation(name, sentence, name in waived) for name, sentence in found)


@dataclass(frozen=True)
class LargestRate:
    """Whether the unit was turned at its largest input rate about every axis, as a sentence."""

    included: bool
    sentence: Message


def largest_rate(calibration: Calibration, configuration: Configuration) -> LargestRate | None:
    """None where nothing was turned at a rate, or the specification does not ask for that rate."""
    where = LARGEST_RATE.get(SPECIFICATIONS[calibration.method].standard)
    held = [segment for segment in calibration.segments if segment.kind == "rate"]
    if where is None or not held:
        return None
    largest, at = configuration.rate_range_deg_s, clause(where)
    if largest is None:
        return LargestRate(False, message("conformity-largest-rate.not-given", clause=at))
    reached = dict.fromkeys(AXES, 0.0)
    for segment in held:
        if segment.axis:
            rate = abs(segment.rate_deg_s or 0.0)
            reached[segment.axis] = max(reached[segment.axis], rate)
    short = [axis for axis in AXES if reached[axis] < FULL_SCALE * largest]
    kind = "missed" if short else "included"
    sentence = message(
        f"conformity-largest-rate.{kind}", clause=at, largest=as_given(largest),
        axes=", ".join(axis.upper() for axis in short),
        reached=as_given(min((reached[axis] for axis in short), default=0.0)),
    )  # fmt: skip
    return LargestRate(not short, sentence)
