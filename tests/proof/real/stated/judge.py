"""Whether a claim of explain's JSON is right, wrong or not known, and the figure for or against."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from tests.proof.real.fact import Answer, Claim, in_words
from tests.proof.real.stated.known import DELAYS, EVERYTHING, Known

Judgement = Literal["right", "wrong", "not known"]
Parameters = Sequence[Mapping[str, Any]]

BY_TRUTH: dict[str, Judgement] = {
    "true": "right", "false": "wrong", "cannot tell": "not known",
}  # fmt: skip


@dataclass(frozen=True)
class Judged:
    """One finding with a name, or an unnamed one that the hand has tried.

    response: name, group and first size. share: of the mismatch that it removes; None where an
    older answer does not state it. evidence: the figure for or against, and where it is from.
    """

    recording: str
    response: str
    share: float | None
    judgement: Judgement
    evidence: str


def judged(
    recording: str, answer: Answer, known: Sequence[Known], tried: Sequence[Claim]
) -> list[Judged]:
    """Every claim of an answer; findings without a name only where the hand has tried them.

    tried: claims on this recording that were tried by hand.
    """
    own = [fact for fact in known if fact.recording == recording]
    found = []
    for finding in answer.get("findings", ()):
        judgement, evidence = _by_facts(finding, answer, own)
        if judgement == "not known":
            by_hand = [one for one in tried if one.made({"findings": [_plain(finding)]})]
            if by_hand:
                judgement, evidence = BY_TRUTH[by_hand[0].truth], by_hand[0].evidence.en
        if finding["effect"] == "unnamed" and judgement == "not known":
            continue
        found.append(
            Judged(recording, response(finding), finding.get("share"), judgement, evidence)
        )
    return found


def response(finding: Mapping[str, Any]) -> str:
    """The name, what it is told together with, and the first size."""
    words = in_words([finding])
    others = [name for name in finding.get("group") or () if name != finding["effect"]]
    if finding["effect"] == "unnamed" and finding.get("follows"):
        words = f"unnamed: {finding['follows']['en']}"
    return words + (f" (or {', '.join(others)})" if others else "")


def _by_facts(
    finding: Mapping[str, Any], answer: Answer, facts: Sequence[Known]
) -> tuple[Judgement, str]:
    names = {finding["effect"], *(finding.get("group") or ())}
    if names == {"unnamed"}:
        return "not known", ""
    about = [fact for fact in facts if names & set(fact.names)]
    about = about or [fact for fact in facts if fact.names == EVERYTHING]
    if not about:
        return "not known", "nothing was measured by hand that would decide it"
    fact = next((one for one in about if one.there), about[0])
    evidence = f"{fact.fact} ({fact.source})"
    if fact.there is None:
        return "not known", evidence
    if not fact.there:
        return "wrong", evidence
    if _agrees(finding, answer, fact):
        return "right", evidence
    return "wrong", f"the name is right, its size is not: {evidence}"


def _agrees(finding: Mapping[str, Any], answer: Answer, fact: Known) -> bool:
    """Whether what is stated, with its U, reaches into the range of every parameter known."""
    together = [finding]
    if fact.names == DELAYS:
        together = [one for one in answer["findings"] if one["effect"] in DELAYS] or together
    stated = [
        each
        for one in together
        for each in (*one["parameters"], *one.get("common", ()))
        if each["name"] in fact.within
    ]
    if fact.names == DELAYS:
        return not stated or _reaches(stated, *next(iter(fact.within.values())))
    return all(_reaches([each], *fact.within[each["name"]]) for each in stated)


def _reaches(stated: Parameters, low: float, high: float) -> bool:
    """Whether the sum of some parameters ± U (k = 2) reaches into a range."""
    value = sum(float(each["value"]) for each in stated)
    expanded = 2.0 * sum(float(each["u"]) ** 2 for each in stated) ** 0.5
    return low - expanded <= value <= high + expanded


def _plain(finding: Mapping[str, Any]) -> Mapping[str, Any]:
    """A finding as the blind answers have it, whose `follows` is plain text."""
    follows = finding.get("follows")
    return {**finding, "follows": follows["en"] if follows else None}
