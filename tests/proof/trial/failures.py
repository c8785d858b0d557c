"""Every case that was not answered right, worst first, with its cause where it is known."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from tests.proof.text import Text, bilingual
from tests.proof.trial.certificate import UNNAMED
from tests.proof.trial.known_causes import FAINT, KNOWN_CAUSES, NOT_KNOWN
from tests.proof.trial.score import Score

KINDS: dict[str, Text] = {
    "failed": bilingual("explain failed", "解释失败"),
    "false alarm": bilingual("false alarm", "误报"),
    "wrong": bilingual("a wrong name", "名称错误"),
    "unnamed": bilingual("left unnamed", "未予命名"),
    "in part": bilingual("only some of several named", "多个因素仅部分命名"),
    "missed": bilingual("nothing found", "未检出"),
}


@dataclass(frozen=True)
class Failure:
    """One case. kind: of KINDS; causes: one at the least."""

    score: Score
    kind: str
    causes: tuple[Text, ...]

    @property
    def truth(self) -> str:
        return " + ".join(self.score.effects) or "clean"

    @property
    def response(self) -> str:
        return ", ".join(self.score.names) or "nothing"


def failures(scores: Sequence[Score]) -> list[Failure]:
    """Every case that failed, by kind and then by truth and z."""
    kinds = list(KINDS)
    found = [Failure(each, kind, causes(each)) for each in scores if (kind := failing(each))]
    return sorted(
        found, key=lambda f: (kinds.index(f.kind), f.truth, min(f.score.z.values(), default=0.0))
    )


def failing(score: Score) -> str | None:
    """How a case failed; None for one that was answered right, a pair with the truth in it too."""
    if score.failed:
        return "failed"
    if score.wrong_beyond_twins:
        return "wrong" if score.effects else "false alarm"
    if not score.effects:
        return "false alarm" if score.detected else None
    if not score.has_a_name:
        return None if score.detected or not score.can_be_determined else "missed"
    if not score.detected:
        return "missed"
    if not score.right_or_twin:
        return "unnamed"
    return "in part" if score.kind == "several" and len(score.named) < len(score.effects) else None


def causes(score: Score) -> tuple[Text, ...]:
    """What is known of why, by the pairs of what is true and was not said, and what was said.

    What is missed at the faintest z needs no other cause than that.
    """
    found = dict.fromkeys(KNOWN_CAUSES[pair] for pair in _pairs(score) if pair in KNOWN_CAUSES)
    if not found and score.kind == "faint" and not score.detected:
        return (FAINT,)
    return tuple(found) or (NOT_KNOWN,)


def _pairs(score: Score) -> Iterator[tuple[str, str]]:
    response = [*score.wrong, *([UNNAMED] if UNNAMED in score.names else [])]
    if not score.detected or score.kind == "several":
        response.append("nothing")
    for truth in score.effects or ("clean",):
        if truth not in score.named:
            yield from ((truth, name) for name in response)
    yield from ((truth, name) for truth in score.named for name in score.wrong)
