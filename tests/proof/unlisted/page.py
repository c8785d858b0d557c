"""The page of the laws that nobody listed."""

from collections.abc import Sequence
from dataclasses import dataclass

from tests.proof.plant.unlisted import BEHAVIOURS, Behaviour
from tests.proof.report import table
from tests.proof.unlisted.judge import OUTCOMES, Judged


@dataclass(frozen=True)
class Answered:
    """One run: its law, z asked, and what was found, with what it cannot be told from."""

    law: str
    behaviour: Behaviour
    z: float
    findings: tuple[tuple[str, tuple[str, ...]], ...]
    worth: Judged


def markdown(every: Sequence[Answered], version: str) -> str:
    """The table of each kind and z, then every run."""
    kinds, runs = [], []
    for behaviour in BEHAVIOURS:
        for z in sorted({one.z for one in every if one.behaviour == behaviour}):
            some = [one for one in every if (one.behaviour, one.z) == (behaviour, z)]
            counts = [sum(one.worth.outcome == each for one in some) for each in OUTCOMES]
            several = sum(one.worth.findings > 1 for one in some)
            kinds.append((behaviour, f"{z:g}", len(some), *counts, several))
    for one in every:
        names = "; ".join(
            name + (f" (or {', '.join(others)})" if others else "") for name, others in one.findings
        )
        runs.append((one.law, f"{one.z:g}", one.worth.outcome, names or "—"))
    return "\n".join([
        "# Forms that nobody listed", "",
        f"mimucal {version}. One run for each law and z; z = 0 is the same run without its law.",
        "",
        *table(("behaviour", "z", "runs", *OUTCOMES, "several findings"), kinds), "",
        *table(("law", "z", "outcome", "found"), runs), "",
    ])  # fmt: skip
