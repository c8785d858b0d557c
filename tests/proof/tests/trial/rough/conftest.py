"""A sealed rough trial of two short recordings, and engines that are no more than a script."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.rough.runs import Encoder, RoughCase
from tests.proof.trial.rough import RoughDrawn, record_and_seal_rough
from tests.proof.trial.seal import set_seals

FINE = Encoder(rate_hz=100, step=1e-4, noise=1e-5)
ENGINE = """#!{python}
import os, pathlib, sys
recording = pathlib.Path(sys.argv[2])
home = pathlib.Path(os.environ["MIMUCAL_HOME"])
assert sys.argv[1] == "explain" and sys.argv[3] == "--json" and not list(home.iterdir())
assert not (recording / "truth.json").exists()
assert "PYTHONPATH" not in os.environ
if recording.name == "{fails_on}":
    sys.exit("it cannot")
print({answer!r})
"""


def shaft(number: int, *effects: str) -> RoughDrawn:
    """A short run of the shaft with these effects."""
    case = Case(seed=8, effects=tuple(EffectCall(name=name) for name in effects))
    rough = RoughCase(case=case, run="shaft", duration_s=25.0, encoder=FINE)
    return RoughDrawn(number=number, kind="mixed" if effects else "control", rough=rough, z=60.0)


@pytest.fixture(scope="session")
def two_rough() -> list[RoughDrawn]:
    """A control, and a step beside a drift of the gain."""
    return [shaft(1), shaft(2, "x_gain_drift", "bias_step_single")]


@pytest.fixture
def sealed_rough(two_rough: list[RoughDrawn], tmp_path: Path) -> Path:
    """The folder of a trial that waits to be explained."""
    folder = tmp_path / "trial"
    for drawn in two_rough:
        record_and_seal_rough(drawn, folder)
    set_seals(folder)
    return folder


@pytest.fixture
def engine(tmp_path: Path) -> Callable[..., Path]:
    """A command that answers every recording alike: <name>/.venv/bin/mimucal."""

    def build(*findings: dict[str, Any], name: str = "own", fails_on: str = "") -> Path:
        answer = {"verdict": "explained", "findings": findings, "left_over": {"gyro_x": 1.2}}
        path = tmp_path / name / ".venv" / "bin" / "mimucal"
        path.parent.mkdir(parents=True)
        text = ENGINE.format(python=sys.executable, fails_on=fails_on, answer=json.dumps(answer))
        path.write_text(text, encoding="utf-8")
        path.chmod(0o755)
        return path

    return build
