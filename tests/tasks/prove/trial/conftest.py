"""Two very short cases, one of them clean, recorded and sealed once."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tasks.prove.plant.case import Case, EffectCall
from tasks.prove.trial.draw import Drawn
from tasks.prove.trial.seal import record_and_seal, set_seals

SHORT: dict[str, Any] = {"seed": 11, "dwell_s": 5.0, "rates_deg_s": (200.0,), "procedure": "rests"}


@pytest.fixture(scope="session")
def two_cases() -> list[Drawn]:
    """A clean one, and biases that follow the temperature, plain to see."""
    warm = EffectCall(name="temperature_bias")
    return [
        Drawn(number=1, kind="clean", case=Case(**SHORT)),
        Drawn(number=2, kind="single", z=60.0, case=Case(**SHORT, effects=(warm,))),
    ]


@pytest.fixture
def sealed(two_cases: list[Drawn], tmp_path: Path) -> Path:
    """The folder of a trial that waits to be explained."""
    for drawn in two_cases:
        record_and_seal(drawn, tmp_path)
    set_seals(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def told() -> Callable[..., dict[str, Any]]:
    """What truth.json says of effects, for a unit with scale factors of 1.01."""

    def build(effects: dict[str, dict[str, Any]], **case: Any) -> dict[str, Any]:
        scale = [[1.01, 0.0, 0.0], [0.0, 1.01, 0.0], [0.0, 0.0, 1.01]]
        return {
            "case": Case(seed=1, **case).model_dump(mode="json"),
            "effects": effects,
            "parameters": {"Kg": scale, "Ka": scale},
        }

    return build
