"""Two very short cases, one of them clean, recorded and sealed once."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from tests.proof.plant.case import Case, EffectCall
from tests.proof.trial.seal import Drawn, record_and_seal, set_seals

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
