"""Two very short cases, one of them clean, recorded and sealed once."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.proof.plant.case import Case, EffectCall
from tests.proof.trial.cost import Cost
from tests.proof.trial.draw import Drawn
from tests.proof.trial.score import Score, scored
from tests.proof.trial.seal import record_and_seal, set_seals

SHORT: dict[str, Any] = {
    "seed": 11,
    "rate_hz": 50,
    "dwell_s": 5.0,
    "rates_deg_s": (200.0,),
    "procedure": "rests",
}


@pytest.fixture(scope="session")
def two_cases() -> list[Drawn]:
    """A clean one, and biases that follow the temperature, plain to see."""
    warm = EffectCall(name="temperature_bias")
    return [
        Drawn(number=1, kind="clean", case=Case(**SHORT)),
        Drawn(number=2, kind="single", z=60.0, case=Case(**SHORT, effects=(warm,))),
    ]


@pytest.fixture(scope="session")
def sealed_once(two_cases: list[Drawn], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sealed")
    for drawn in two_cases:
        record_and_seal(drawn, folder)
    set_seals(folder)
    return folder


@pytest.fixture
def sealed(sealed_once: Path, tmp_path: Path) -> Path:
    """The folder of a trial that waits to be explained; of each test its own."""
    return shutil.copytree(sealed_once, tmp_path, dirs_exist_ok=True)


@pytest.fixture(scope="session")
def declared() -> Callable[..., dict[str, Any]]:
    """What truth.json says of effects, for a unit with scale factors of 1.01."""

    def build(effects: dict[str, dict[str, Any]], **case: Any) -> dict[str, Any]:
        scale = [[1.01, 0.0, 0.0], [0.0, 1.01, 0.0], [0.0, 0.0, 1.01]]
        return {
            "case": Case(seed=1, **case).model_dump(mode="json"),
            "effects": effects,
            "parameters": {"Kg": scale, "Ka": scale},
        }

    return build


@pytest.fixture
def answered(declared: Callable[..., dict[str, Any]]) -> Callable[..., Score]:
    """Scores findings, each a name or a name with its twins, for a truth."""

    def build(effects: dict[str, Any], *findings: str | tuple[str, ...], kind: str = "single",
              z: float | None = 30.0) -> Score:  # fmt: skip
        response = [
            {"effect": each[0], "indistinguishable_from": list(each[1:]), "parameters": []}
            for each in ((one,) if isinstance(one, str) else one for one in findings)
        ]
        trial = {
            "kind": kind,
            "asked_z": z,
            "z": dict.fromkeys(effects, 30.0),
            "concealment": dict.fromkeys(effects, 0.5),
        }
        answer = {"verdict": "explained", "findings": response, "seconds": 1.0}
        cost = Cost(3.0, 0.5, "accel_bias x", True, "fail", "pass", True)
        return scored("0001", declared(effects), trial, answer, None, cost)

    return build
