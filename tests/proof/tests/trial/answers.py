"""Answers of `explain`, made up, and what they are worth."""

from typing import Any

from tests.proof.plant.case import Case
from tests.proof.trial.score import Cost, Score, scored


def declared(effects: dict[str, dict[str, Any]], **case: Any) -> dict[str, Any]:
    """What truth.json says of effects, for a unit with scale factors of 1.01."""
    scale = [[1.01, 0.0, 0.0], [0.0, 1.01, 0.0], [0.0, 0.0, 1.01]]
    return {
        "case": Case(seed=1, **case).model_dump(mode="json"), "effects": effects,
        "parameters": {"Kg": scale, "Ka": scale},
    }  # fmt: skip


def answered(
    effects: dict[str, Any], *findings: str | tuple[str, ...], kind: str = "single",
    z: float | None = 30.0,
) -> Score:  # fmt: skip
    """The score of findings, each a name or a name with its twins, for a truth."""
    response = [
        {"effect": each[0], "indistinguishable_from": list(each[1:]), "parameters": []}
        for each in ((one,) if isinstance(one, str) else one for one in findings)
    ]
    trial = {
        "kind": kind, "asked_z": z, "z": dict.fromkeys(effects, 30.0),
        "concealment": dict.fromkeys(effects, 0.5),
    }  # fmt: skip
    answer = {"verdict": "explained", "findings": response, "seconds": 1.0}
    cost = Cost(3.0, 0.5, "accel_bias x", True, "fail", "pass", True)
    return scored("0001", declared(effects), trial, answer, None, cost)


def finding(effect: str, *group: str, **parameters: tuple[float, float, str]) -> dict[str, Any]:
    """A finding as the engine's JSON says it."""
    return {
        "effect": effect, "group": [effect, *group] if group else None,
        "indistinguishable_from": [],
        "parameters": [
            {"name": name, "value": value, "u": u, "unit": unit}
            for name, (value, u, unit) in parameters.items()
        ],
    }  # fmt: skip
