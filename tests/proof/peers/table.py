"""What `explain` and its peers do of the five duties, by kind of case."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from tests.proof.peers.score import METHODS, PeerScore
from tests.proof.trial.table import Rate


@dataclass(frozen=True)
class Duties:
    """One method on the cases of one kind.

    locate: channels right. name: first name right, of those that have one; wrong: any name wrong.
    model: median share of the gap closed. show: unseen segments are predicted better. abstain:
    nothing named where nothing can be. seconds: median of one recording.
    """

    kind: str
    method: str
    cases: int
    detected: Rate
    locate: Rate
    name: Rate
    wrong: Rate
    model: float | None
    show: Rate
    abstain: Rate
    seconds: float

    def response(self) -> dict[str, Any]:
        """As plain data."""
        values = ((name, getattr(self, name)) for name in self.__dataclass_fields__)
        return {
            name: value.response() if isinstance(value, Rate) else value for name, value in values
        }


def kinds_of(scores: Iterable[PeerScore]) -> dict[str, list[PeerScore]]:
    """Clean cases, single effects by z, several, what is outside the catalogue; those there are."""
    kinds: dict[str, Callable[[PeerScore], bool]] = {
        "clean": lambda one: one.score.kind == "clean",
        **{
            f"one effect, z {z:g}": lambda one, z=z: (  # type: ignore[misc]
                one.score.kind in ("single", "faint") and one.score.asked_z == z
            )
            for z in (5.0, 10.0, 30.0, 100.0)
        },
        "several effects": lambda one: one.score.kind == "several",
        "outside the catalogue": lambda one: one.score.kind == "outside",
    }
    every = list(scores)
    listed = {name: [one for one in every if belongs(one)] for name, belongs in kinds.items()}
    return {name: group for name, group in listed.items() if group}


def duties_of(scores: Iterable[PeerScore]) -> list[Duties]:
    """A row for each kind of case and each method."""
    return [
        duties(kind, method, own)
        for kind, group in kinds_of(scores).items()
        for method in METHODS
        if (own := [one for one in group if one.method == method])
    ]


def duties(kind: str, method: str, scores: Sequence[PeerScore]) -> Duties:
    """The figures of some cases, at least one."""
    hidden = [one for one in scores if one.located is not None]
    nameable = [one for one in scores if one.score.has_a_name]
    nameless = [one for one in scores if one.abstained is not None]
    gaps = [one.score.gap.closed for one in scores if one.score.gap is not None]

    def rate(of: Sequence[PeerScore], holds: Callable[[PeerScore], object]) -> Rate:
        return Rate(sum(bool(holds(one)) for one in of), len(of))

    return Duties(
        kind, method, len(scores),
        detected=rate(scores, lambda one: one.score.detected),
        locate=rate(hidden, lambda one: one.located),
        name=rate(nameable, lambda one: one.score.right),
        wrong=rate(scores, lambda one: one.score.wrong),
        model=median(gaps) if gaps else None,
        show=rate(hidden, lambda one: one.shown),
        abstain=rate(nameless, lambda one: one.abstained),
        seconds=median(one.score.seconds for one in scores),
    )  # fmt: skip
