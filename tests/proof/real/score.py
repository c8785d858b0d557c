"""Scores of what was hidden: the answer beside that of the untouched recording."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tests.proof.real.cases import Hidden
from tests.proof.real.fact import Answer, findings, parameter
from tests.proof.real.hand.measured import Measured
from tests.proof.real.on_shaft import total_delay

NORMAL_95 = 1.959964


@dataclass(frozen=True)
class Score:
    """One hidden transformation. new: names beyond the untouched recording's, without `unnamed`.

    stated: what the answer says beyond the untouched one. by_hand: the same by hand analysis.
    """

    case: Hidden
    new: tuple[str, ...]
    named: bool
    stated: Measured | None
    by_hand: Measured | None
    seconds: float
    failed: str | None

    @property
    def visible(self) -> bool:
        """There is something hidden that can be seen."""
        return self.case.why is None and self.case.size.value != 0.0

    @property
    def wrong(self) -> tuple[str, ...]:
        """New names that are not what was hidden; where nothing can be seen, any."""
        return tuple(name for name in self.new if not self.visible or name != self.case.name)

    @property
    def inside(self) -> bool:
        """The stated change holds the hidden amount in its 95 % interval."""
        if self.stated is None:
            return False
        return abs(self.stated.value - self.case.size.value) <= NORMAL_95 * self.stated.u

    @property
    def outcome(self) -> str:
        """What became of it, the worst first."""
        if self.failed:
            return "explain failed"
        if self.wrong:
            return "a wrong name"
        if not self.visible:
            return "rightly nothing new"
        if not self.named:
            return "missed"
        return "found, value right" if self.inside else "found, value off"


def scored(case: Hidden, answer: Answer, base: Answer, by_hand: Measured | None) -> Score:
    """The score of one answer; base: that of the untouched recording."""
    names, before = _names(answer), _names(base)
    new = tuple(sorted(names - before))
    return Score(
        case,
        new,
        case.name in names,
        _stated(case, answer, base) if case.why is None else None,
        by_hand,
        float(answer["seconds"]),
        answer.get("failed"),
    )


def as_data(score: Score) -> Mapping[str, Any]:
    """A score as plain data."""
    size = score.case.size
    return {
        "recording": score.case.recording,
        "hidden": score.case.name,
        "size": size.value,
        "unit": size.unit,
        "at": size.at,
        "can_be_seen": score.case.why is None,
        "new_names": list(score.new),
        "stated": score.stated and vars(score.stated),
        "by_hand": score.by_hand and vars(score.by_hand),
        "outcome": score.outcome,
        "seconds": score.seconds,
    }


def _names(answer: Answer) -> set[str]:
    return {each["effect"] for each in answer.get("findings", ())} - {"unnamed"}


def _stated(case: Hidden, answer: Answer, base: Answer) -> Measured | None:
    after, before = _amount(case.name, answer), _amount(case.name, base)
    if after is None:
        return None
    value, u = before or (0.0, 0.0)
    return Measured(after[0] - value, (after[1] ** 2 + u**2) ** 0.5, case.size.unit)


def _amount(name: str, answer: Answer) -> tuple[float, float] | None:
    """How much of an effect an answer states, and its u: all delays, all lost samples together."""
    if name == "time_offset":
        return total_delay(answer)
    response = findings(answer, name)
    if not response:
        return None
    if name == "table_scale":
        return parameter(response[0], "scale")
    lost = [p for p in response[0]["parameters"] if p["name"].startswith("lost_")]
    return sum(p["value"] for p in lost), sum(p["u"] ** 2 for p in lost) ** 0.5
