"""Three short rough runs: a table, a motor shaft and a body moved by hand."""

from functools import lru_cache
from typing import Any

import numpy as np

from schemas.recording import ACCEL, GYRO
from tests.proof.plant.case import Case, EffectCall, draw_unit
from tests.proof.plant.rough.play import Played, play
from tests.proof.plant.rough.runs import Encoder, RoughCase, Tracking

FINE = Encoder(rate_hz=100, step=1e-7, noise=0.0)
CLEAR = Tracking(rate_hz=120, position_noise=0.0, attitude_noise=0.0)
RUNS: dict[str, dict[str, Any]] = {
    "table": {"run": "table", "encoder": FINE},
    "shaft": {"run": "shaft", "encoder": FINE, "duration_s": 40.0, "axis": (1.0, 0.0, 0.0)},
    "hand": {"run": "hand", "tracking": CLEAR, "duration_s": 30.0},
}


@lru_cache(maxsize=32)
def _played(text: str) -> Played:
    return play(RoughCase.model_validate_json(text))


def rough_of(
    run: str, *effects: str, fields: dict[str, Any] | None = None, strength: float = 1.0,
    **parameters: Any,
) -> RoughCase:  # fmt: skip
    """A short case of a run with effects; fields replace the case's."""
    calls = tuple(
        EffectCall(name=name, parameters=parameters, strength=strength) for name in effects
    )
    case = Case(seed=6, procedure="one_axis", dwell_s=5.0, rates_deg_s=(100.0,), effects=calls)
    return RoughCase(case=case, **(RUNS[run] | (fields or {})))


def played(rough: RoughCase) -> Played:
    """Plays a case; the same case only once."""
    return _played(rough.model_dump_json())


def excess(run: Played) -> np.ndarray:
    """What the noise-free readings have beyond the standard's model on the reported motion."""
    unit = draw_unit(run.rough.case.seed)
    return run.truth.T - unit.reads(run.reported[:, :3].T, run.reported[:, 3:].T)


def readings(run: Played) -> np.ndarray:
    """The recorded readings, (6, n)."""
    return run.recording.imu.stack(GYRO + ACCEL).T
