"""Opens the seals of a rough trial and holds each answer against the truth."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.proof.plant.effects.memory import BiasStep
from tests.proof.plant.effects.outside_sensors import Telegraph
from tests.proof.trial.certificate import UNNAMED
from tests.proof.trial.compare import Compared
from tests.proof.trial.rough.compare import compared_rough
from tests.proof.trial.rough.engine import ANSWER, COST, TROUBLE
from tests.proof.trial.seal import SEALED, check_seals

PLAIN = 30.0  # z from which a listed effect should be named


@dataclass(frozen=True)
class Listed:
    """A listed effect that was hidden. called: its form. z: how far it stands above all else."""

    called: str
    name: str
    z: float
    named: bool
    in_group: bool


@dataclass(frozen=True)
class RoughScore:
    """One answered recording.

    truth: what was hidden, as called; nuisances: what the reference brings along. wrong: names
    that are neither true nor in a group with a true one; a telegraph signal that jumps once in the
    run is also a bias step; in_group: names that are not true
    themselves but stand in such a group. left_over: χ²/dof after explaining by channel; of an
    engine that does not tell it, that of the segments held out. z of what is outside the catalogue
    is not among `listed`.
    """

    number: str
    kind: str
    run: str
    truth: tuple[str, ...]
    nuisances: tuple[str, ...]
    names: tuple[str, ...]
    wrong: tuple[str, ...]
    in_group: tuple[str, ...]
    listed: tuple[Listed, ...]
    parameters: tuple[Compared, ...]
    left_over: dict[str, float]
    verdict: str
    seconds: float
    failed: str | None

    @property
    def worst_left(self) -> float | None:
        """The largest χ²/dof that stays."""
        return max(self.left_over.values(), default=None)


def score_rough(folder: Path, answers: Path) -> list[RoughScore]:
    """Checks the seals, then scores every answer there is. Raises Unusable for a broken seal."""
    check_seals(folder)
    return [
        _score(folder / SEALED / each.name, each)
        for each in sorted(answers.iterdir())
        if (each / COST).exists()
    ]


def _score(sealed: Path, answers: Path) -> RoughScore:
    declared, trial = _json(sealed / "truth.json"), _json(sealed / "trial.json")
    response = (answers / ANSWER).read_text(encoding="utf-8")
    failed = None if response else (answers / TROUBLE).read_text(encoding="utf-8").strip()[-300:]
    seconds = float((answers / COST).read_text(encoding="utf-8"))
    answer = json.loads(response) if response else {"findings": []}
    return scored_rough(sealed.name, declared, trial, answer, seconds, failed)


def scored_rough(
    number: str,
    declared: dict[str, Any],
    trial: dict[str, Any],
    answer: dict[str, Any],
    seconds: float,
    failed: str | None = None,
) -> RoughScore:
    """The score from what truth.json, trial.json and the engine's answer say."""
    hidden = {each["called"]: each["name"] for each in declared["effects"]}
    true = {*hidden.values(), *declared["nuisances"], *_also_true(declared["effects"])}
    named = [one for one in answer["findings"] if one["effect"] != UNNAMED]
    false = [one for one in named if one["effect"] not in true]
    stated_of = {name for one in named for name in group_of(one)}
    names = {one["effect"] for one in named}
    return RoughScore(
        number=number,
        kind=trial["kind"],
        run=declared["case"]["run"],
        truth=tuple(hidden),
        nuisances=tuple(declared["nuisances"]),
        names=tuple(one["effect"] for one in answer["findings"]),
        wrong=tuple(one["effect"] for one in false if not group_of(one) & true),
        in_group=tuple(one["effect"] for one in false if group_of(one) & true),
        listed=tuple(
            Listed(called, name, trial["z"][called], name in names, name in stated_of)
            for called, name in hidden.items()
            if not name.startswith("x_")
        ),
        parameters=tuple(compared_rough(declared, named)),
        left_over=_left_over(answer),
        verdict=answer.get("verdict", "failed"),
        seconds=seconds,
        failed=failed,
    )


def _also_true(effects: list[dict[str, Any]]) -> set[str]:
    """Catalogue names of what is outside the catalogue but drawn so that it is one of its effects:
    a telegraph signal that jumps once is a bias that steps.
    """
    telegraphs = (each for each in effects if each["name"] == Telegraph.name)
    return {BiasStep.name for each in telegraphs if len(each["parameters"]["times"]) == 1}


def group_of(finding: dict[str, Any]) -> set[str]:
    """Every name that a finding offers for what it found."""
    others = [*(finding.get("group") or ()), *finding["indistinguishable_from"]]
    return {finding["effect"], *others}


def _left_over(answer: dict[str, Any]) -> dict[str, float]:
    held_out = answer.get("held_out")
    beside = {"held out": held_out["chi2_per_dof_after"]} if held_out else {}
    return answer.get("left_over") or beside


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))
