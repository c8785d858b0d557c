"""Opens the seals and holds each answer against the truth."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq

from schemas.recording import ACCEL, GYRO
from tests.proof.plant.grades import channel_noise
from tests.proof.trial.blind import ANSWER, PREDICTION
from tests.proof.trial.certificate import CERTIFICATE, UNNAMED
from tests.proof.trial.compare import Compared, compared
from tests.proof.trial.cost import Cost, cost_of
from tests.proof.trial.draw import ABSORBED
from tests.proof.trial.limit import freedom_of
from tests.proof.trial.parameters import Truth
from tests.proof.trial.seal import SEALED, check_seals

ANSWERS = "answers"


@dataclass(frozen=True)
class Gap:
    """Misfits to the noise-free truth, Σ|…|²/σ², σ the white noise of the grade.

    first: of the standard's model, fitted. left: with the findings. floor: what noise alone makes
    of the standard's parameters.
    """

    first: float
    left: float
    floor: float

    @property
    def closed(self) -> float:
        """1 − Σ|truth − found|²/σ² / Σ|truth − nominal|²/σ²."""
        return 1.0 - self.left / self.first

    @property
    def of_closable(self) -> float | None:
        """What was closed, of what the noise lets be closed; None where that is nothing."""
        closable = self.first - self.floor
        return (self.first - self.left) / closable if closable > 0.0 else None


@dataclass(frozen=True)
class Score:
    """What one answer is worth.

    z, concealment, freedom (how many numbers its form leaves open): of each true effect.
    names: of the findings, in their order, `unnamed` among them. A name's twins are what its
    finding lists as indistinguishable from it.
    right: the first name is a true one. right_or_twin: it or one of its twins is.
    wrong: names that are not true; wrong_beyond_twins: of them those without a true twin.
    cost: what missing it costs, None where the clauses give no item. gap: None for clean cases
    and failures. parameters: of effects named rightly.
    """

    number: str
    kind: str
    effects: tuple[str, ...]
    asked_z: float | None
    z: dict[str, float]
    concealment: dict[str, float]
    freedom: dict[str, int]
    conditions: dict[str, Any]
    verdict: str
    names: tuple[str, ...]
    right: bool
    right_or_twin: bool
    wrong: tuple[str, ...]
    wrong_beyond_twins: tuple[str, ...]
    cost: Cost | None
    gap: Gap | None
    parameters: tuple[Compared, ...]
    uncompared: tuple[str, ...]
    seconds: float
    failed: str | None

    @property
    def detected(self) -> bool:
        return bool(self.names)

    @property
    def abstained(self) -> bool:
        """Found, and left without a name."""
        return self.detected and all(name == UNNAMED for name in self.names)

    @property
    def named(self) -> tuple[str, ...]:
        """The true effects that were named."""
        return tuple(effect for effect in self.effects if effect in self.names)

    @property
    def can_be_determined(self) -> bool:
        """Whether the data show it at all: the standard absorbs another gravity whole."""
        return self.effects != (ABSORBED,)

    @property
    def has_a_name(self) -> bool:
        """Whether a name of the catalogue would be right."""
        return self.can_be_determined and any(not e.startswith("x_") for e in self.effects)


def score_all(folder: Path) -> list[Score]:
    """Checks the seals, then scores every answer. Raises Unusable for a broken seal."""
    check_seals(folder)
    return [score(folder, each.name) for each in sorted((folder / SEALED).iterdir())]


def score(folder: Path, number: str) -> Score:
    """One answer against its truth."""
    sealed, answers = folder / SEALED / number, folder / ANSWERS / number
    declared = _json(sealed / "truth.json")
    answer = _json(answers / ANSWER)
    trial, stated, gap = _json(sealed / "trial.json"), _json(answers / CERTIFICATE), None
    if declared["effects"] and "failed" not in answer:
        first, left = misfits(sealed / "truth.parquet", answers / PREDICTION, declared["case"])
        gap = Gap(first, left, trial["floor"])
    seed = declared["case"]["seed"]
    cost = cost_of(trial["certificate"], stated["read"], stated["less"], seed)
    if "failed" in stated:
        answer.setdefault("failed", f"calibrate --terms: {stated['failed']}")
    return scored(number, declared, trial, answer, gap, cost)


def scored(
    number: str,
    declared: dict[str, Any],
    trial: dict[str, Any],
    answer: dict[str, Any],
    gap: Gap | None,
    cost: Cost | None = None,
) -> Score:
    """The score from what truth.json, trial.json and answer.json say."""
    case, effects = declared["case"], tuple(declared["effects"])
    findings = answer.get("findings", [])
    named = [one for one in findings if one["effect"] != UNNAMED]
    wrong = [one for one in named if one["effect"] not in effects]
    truth = Truth(declared["effects"], declared["parameters"], case)
    beside = [
        compared(truth, one["effect"], one["parameters"])
        for one in named
        if one["effect"] in effects
    ]
    shown = ("grade", "procedure", "rate_hz", "rates_deg_s", "dwell_s", "order", "climate",
             "latitude_deg", "heading_deg", "temperature_recorded", "site_known")  # fmt: skip
    return Score(
        number=number,
        kind=trial["kind"],
        effects=effects,
        asked_z=trial["asked_z"],
        z=trial["z"],
        concealment=trial["concealment"],
        freedom={effect: freedom_of(truth, effect) for effect in effects},
        conditions={name: case[name] for name in shown},
        verdict=answer.get("verdict", "failed"),
        names=tuple(one["effect"] for one in findings),
        right=bool(named) and named[0]["effect"] in effects,
        right_or_twin=bool(named) and _true_or_twin(named[0], effects),
        wrong=tuple(one["effect"] for one in wrong),
        wrong_beyond_twins=tuple(one["effect"] for one in wrong if not _true_or_twin(one, effects)),
        cost=cost,
        gap=gap,
        parameters=tuple(pair for pairs, _ in beside for pair in pairs),
        uncompared=tuple(name for _, alone in beside for name in alone),
        seconds=answer["seconds"],
        failed=answer.get("failed"),
    )


def _true_or_twin(finding: dict[str, Any], effects: tuple[str, ...]) -> bool:
    return not {finding["effect"], *finding["indistinguishable_from"]}.isdisjoint(effects)


def misfits(truth: Path, prediction: Path, case: dict[str, Any]) -> tuple[float, float]:
    """Σ|truth − nominal|²/σ² and Σ|truth − found|²/σ² over the rows where both are known."""
    true, response = pq.read_table(truth), pq.read_table(prediction)
    left = first = 0.0
    for channel, noise in zip(GYRO + ACCEL, channel_noise(case["grade"]), strict=True):
        sigma = noise.white * np.sqrt(case["rate_hz"] / 2.0)
        series = true[channel].to_numpy()
        found, nominal = (
            (series - response[f"{channel}_{which}"].to_numpy()) / sigma
            for which in ("found", "nominal")
        )
        known = np.isfinite(found) & np.isfinite(nominal)
        left += float(found[known] @ found[known])
        first += float(nominal[known] @ nominal[known])
    return first, left


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))
