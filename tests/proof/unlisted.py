"""What an answer is worth: a name is right where it is that of the kind of behaviour."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import typer

from tasks.explain.explain import explain
from tasks.version import code_version
from tests.proof.plant.unlisted import BEHAVIOURS, LAWS, Behaviour, case_of, recordings
from tests.proof.study import Minutes, Out, Write, hold, table

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


# The page of the laws that nobody listed.


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


# `python -m tests.proof.unlisted --out DIR`: laws that nobody listed, and clean runs of theirs.

VISIBILITIES = (0.0, 10.0, 30.0, 100.0)  # 0: the same run without the law


def unlisted(
    seed: Annotated[int, typer.Option(min=0, help="Of the first law's run.")] = 4701,
    out: Out = None, minutes: Minutes = None, write: Write = False,
) -> None:  # fmt: skip
    """Laws in forms that nobody listed, at each visibility, and the same runs without them."""
    work = {f"{seed}-{name}": (name, seed + n) for n, name in enumerate(LAWS)}
    hold("unlisted", work, _answered, _page, out, minutes=minutes, write=write)


def _answered(work: tuple[str, int]) -> list[Answered]:
    law, seed, every = LAWS[work[0]], work[1], list[Answered]()
    for z, recording in zip(VISIBILITIES, recordings(law, case_of(law, seed), VISIBILITIES),
                            strict=True):  # fmt: skip
        found = tuple(
            (one.effect, (*one.group, *one.indistinguishable))
            for one in explain(recording).findings
        )
        worth = judged(law.behaviour if z else None, found)
        every.append(Answered(law.name, law.behaviour, z, found, worth))
    return every


def _page(found: Sequence[list[Answered]]) -> str:
    return markdown([one for law in found for one in law], code_version())
