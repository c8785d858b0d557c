"""The page of all claims on real recordings, as Markdown and as data."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from tests.proof.real.stated.judge import Judged
from tests.proof.real.stated.run import Cost

HEAD = ("recording", "explain says (± u)", "share", "judgement", "the figure for or against")
COSTS = ("recording", "s before", "s now", "MiB before", "MiB now", "explained share", "unnamed")


@dataclass(frozen=True)
class Answered:
    """One recording: what explain said of it and what that cost; before: an older engine's cost."""

    recording: str
    answer: Mapping[str, Any] | None
    claims: tuple[Judged, ...]
    cost: Cost
    before: Cost | None


def markdown(every: Sequence[Answered], code_version: str) -> str:
    """Counts, all claims, and what each recording cost."""
    claims = [claim for one in every for claim in one.claims]
    counts = {
        word: sum(claim.judgement == word for claim in claims)
        for word in ("right", "wrong", "not known")
    }
    return "\n".join([
        "# Every claim on every real recording", "",
        "Each named finding of explain, held against what the recording's makers document and "
        "what was measured on it by hand. A claim is wrong where the effect is not there, or where "
        "its size with U misses what was measured.", "",
        f"{len(claims)} claims: " + ", ".join(f"{n} {word}" for word, n in counts.items()) + ".",
        "", *_table(HEAD, [_claim(claim) for claim in claims]), "",
        "Processor time of one core and largest memory, start of the program included; before: "
        "commit 230cf52.", "", *_table(COSTS, [_cost(one) for one in every]), "",
        f"{code_version}.", "",
    ])  # fmt: skip


def data(every: Sequence[Answered], code_version: str) -> dict[str, Any]:
    """`mimu-stated-real/1`."""
    return {
        "format": "mimu-stated-real/1",
        "code_version": code_version,
        "recordings": [
            {
                "recording": one.recording,
                "verdict": one.answer and one.answer["verdict"],
                "claims": [asdict(claim) for claim in one.claims],
                "cost": asdict(one.cost),
                "before": one.before and asdict(one.before),
            }
            for one in every
        ],
    }


def _claim(claim: Judged) -> tuple[str, ...]:
    share = "—" if claim.share is None else f"{100.0 * claim.share:.0f} %"
    return (claim.recording, claim.response, share, claim.judgement, claim.evidence)


def _cost(one: Answered) -> tuple[str, ...]:
    before, now = one.before, one.cost
    declared = one.answer or {}
    share = declared.get("explained_share")
    unnamed = sum(each["effect"] == "unnamed" for each in declared.get("findings", ()))
    return (
        one.recording,
        "—" if before is None else f"{before.seconds:.1f}",
        f"{now.seconds:.1f}",
        "—" if before is None else f"{before.memory:.0f}",
        f"{now.memory:.0f}",
        "refused" if one.answer is None else "—" if share is None else f"{100.0 * share:.0f} %",
        str(unnamed),
    )


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    lines = [f"| {' | '.join(head)} |", f"|{'---|' * len(head)}"]
    return [*lines, *(f"| {' | '.join(cell.replace('|', '/') for cell in r)} |" for r in rows)]
