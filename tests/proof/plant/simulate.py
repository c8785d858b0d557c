"""A case as a recording, with its truth beside it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from schemas.recording import Recording
from tests.proof.plant.case import Case
from tests.proof.plant.grades import channel_noise
from tests.proof.plant.noise import noise
from tests.proof.plant.noise_free_case import NoiseFree, without_noise
from tests.proof.plant.recording import recording_of
from tests.proof.plant.seeds import generator


@dataclass(frozen=True)
class Simulated:
    """recording: what is handed out. The rest is sealed.

    truth, nominal: (n, 6), one row for each row of the unit's stream; see `Heard` for what is in
    them. reported: (n, 6), rates rad/s and specific force m/s² that the table reports. sealed:
    truth.json: grade, parameters of unit and effects in SI, and units.
    """

    case: Case
    recording: Recording
    truth: np.ndarray
    nominal: np.ndarray
    reported: np.ndarray
    sealed: dict[str, Any]


def simulate(case: Case) -> Simulated:
    """Plays a case with noise, limits and rounding. Raises ValueError for an impossible case."""
    return simulated_from(case, without_noise(case))


def simulated_from(case: Case, noise_free: NoiseFree) -> Simulated:
    """The recording of a case whose readings without noise are known."""
    readings = noise_free.analog + noise_free.shaken + _noise(case, noise_free.truth.shape[1])
    for effect in noise_free.effects:
        if (limits := effect.limits()) is not None:
            readings = np.clip(readings, -limits[:, None], limits[:, None])
    steps = noise_free.steps[:, None]
    readings = np.round(readings / steps) * steps
    return Simulated(
        case,
        recording_of(case, noise_free, readings),
        noise_free.truth.T,
        noise_free.nominal.T,
        noise_free.reported.T,
        sealed_of(case, noise_free),
    )


def sealed_of(case: Case, noise_free: NoiseFree) -> dict[str, Any]:
    """The truth as plain data: every parameter in SI with its unit."""
    return {
        "case": case.model_dump(mode="json"),
        "effects": {effect.name: dict(effect.parameters) for effect in noise_free.effects},
        "units": {effect.name: dict(effect.units) for effect in noise_free.effects},
        "grade": case.grade,
        "parameters": noise_free.unit.parameters(),
    }


def _noise(case: Case, count: int) -> np.ndarray:
    """(6, n): every channel its own, the same whatever the effects."""
    return np.stack([
        noise(generator(case.seed, f"noise {channel}"), model, count, case.rate_hz)
        for channel, model in enumerate(channel_noise(case.grade))
    ])  # fmt: skip
