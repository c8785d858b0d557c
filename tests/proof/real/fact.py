"""Something that is known of a real recording, and what an answer of `explain` says of it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from schemas.recording import Recording
from tests.proof.text import Text

Answer = Mapping[str, Any]  # answer.json of tests.proof.trial.blind
Recordings = Mapping[str, Recording]
Truth = Literal["true", "false", "cannot tell"]


@dataclass(frozen=True)
class Fact:
    """An effect that is really there, shown by hand in two ways.

    how, size: of each of the two ways. unknown: what they do not tell. names: of the catalogue
    that would be right. declared: what an answer says of it, and whether that is right, wrong or
    silent.
    """

    key: str
    recordings: tuple[str, ...]
    what: Text
    how: tuple[Text, Text]
    size: tuple[str, str]
    unknown: Text
    declared: Callable[[Answer], "Judged"]


@dataclass(frozen=True)
class Judged:
    """What an answer says of a fact: in words, and whether it is right."""

    words: str
    outcome: Literal["right", "right name, value off", "wrong", "silent", "explain failed"]


@dataclass(frozen=True)
class Claim:
    """Something that explain says, or said once, of a recording, tried by hand.

    made: whether an answer makes it. evidence: the numbers of the trial by hand.
    """

    recording: str
    what: Text
    truth: Truth
    evidence: Text
    made: Callable[[Answer], bool]


def findings(answer: Answer, *effects: str, channel: str = "") -> list[Mapping[str, Any]]:
    """The findings of some names, seen in a channel if one is asked for."""
    return [
        each
        for each in answer.get("findings", ())
        if each["effect"] in effects and (not channel or channel in each["channels"])
    ]


def parameter(finding: Mapping[str, Any], name: str) -> tuple[float, float] | None:
    """Value and u of the first parameter of a name."""
    for each in finding["parameters"]:
        if each["name"] == name:
            return float(each["value"]), float(each["u"])
    return None


def lines_at(answer: Answer, frequency: float, within: float) -> list[Mapping[str, Any]]:
    """The findings with a frequency near one, Hz."""
    return [
        each
        for each in answer.get("findings", ())
        if (response := parameter(each, "frequency")) and abs(response[0] - frequency) < within
    ]


def in_words(some: Sequence[Mapping[str, Any]]) -> str:
    """Names and first parameters, as explain states them."""
    response = []
    for each in some:
        stated = [p for p in each["parameters"] if p["u"] > 0.0][:1]
        numbers = "".join(f" {p['value']:.4g} ± {p['u']:.2g} {p['unit']}" for p in stated)
        response.append(f"{each['effect']}{numbers}")
    return "; ".join(response) or "—"


def silent(answer: Answer) -> Judged:
    """Nothing is said; a failure of explain is said as one, by its first line."""
    if "failed" in answer:
        return Judged(answer["failed"].splitlines()[0], "explain failed")
    return Judged("—", "silent")
