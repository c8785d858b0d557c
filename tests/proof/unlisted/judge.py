"""What an answer is worth: a name is right where it is that of the kind of behaviour."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from tests.proof.plant.unlisted import Behaviour

UNNAMED = "unnamed"
NAMES: Mapping[Behaviour, frozenset[str]] = {
    "hysteresis": frozenset({"hysteresis"}),
    "non-linearity": frozenset(
        {"gyro_scale_nonlinearity", "gyro_scale_asymmetry", "accel_nonlinearity"}
    ),
    "rectification": frozenset({"vibration_rectification"}),
    "late temperature": frozenset({"temperature_bias", "thermal_gradient", "thermal_transient"}),
}
Outcome = Literal["right", "unnamed", "wrong", "silent"]
OUTCOMES: tuple[Outcome, ...] = ("right", "unnamed", "wrong", "silent")


@dataclass(frozen=True)
class Judged:
    """findings: how many there are for the one effect. outcome: right: the first name is one of the
    kind's, and none is wrong; unnamed: found, without a name; silent: not found.
    """

    outcome: Outcome
    findings: int


def judged(behaviour: Behaviour | None, findings: Sequence[tuple[str, Sequence[str]]]) -> Judged:
    """findings: the name of each, and the names that it cannot be told from, largest first.

    behaviour: none of a clean recording, where every name is wrong.
    """
    own = NAMES[behaviour] if behaviour else frozenset()
    named = [({name, *others}, name) for name, others in findings if name != UNNAMED]
    if any(own.isdisjoint(possible) for possible, _ in named):
        return Judged("wrong", len(findings))
    if named:
        return Judged("right", len(findings))
    return Judged("unnamed" if findings else "silent", len(findings))
