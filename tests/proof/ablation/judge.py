"""What one answer says that is right and wrong, by what is known of the recording."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tests.proof.trial.blind import UNNAMED

Answer = Mapping[str, Any]


@dataclass(frozen=True)
class Verdict:
    """right: names that are true or stand in a group with a true one. wrong: the others, as far as
    the recording is known well enough. inside, stated: intervals with a truth beside them.
    """

    right: tuple[str, ...]
    wrong: tuple[str, ...]
    inside: int = 0
    stated: int = 0


def by_names(answer: Answer, true: set[str], pairs: tuple[int, int] = (0, 0)) -> Verdict:
    """By the names of all that is true of a recording. pairs: intervals inside, and of how many."""
    named = [one for one in answer["findings"] if one["effect"] != UNNAMED]
    right = [one for one in named if offered(one) & true]
    wrong = [one for one in named if not offered(one) & true]
    return Verdict(
        tuple(one["effect"] for one in right), tuple(one["effect"] for one in wrong), *pairs
    )


def offered(finding: Mapping[str, Any]) -> set[str]:
    """Every name that a finding offers for what it found."""
    return {
        finding["effect"], *(finding.get("group") or ()), *finding["indistinguishable_from"],
    }  # fmt: skip
