"""A case as a recording, with its truth beside it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from schemas.recording import Recording
from tests.proof.plant.case import Case
from tests.proof.plant.grades import channel_noise
from tests.proof.plant.hearing import Heard, hear
from tests.proof.plant.noise import noise
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
    heard = hear(case)
    readings = heard.analog + heard.shaken + _noise(case, heard.truth.shape[1])
    for effect in heard.effects:
        if (limits := effect.limits()) is not None:
            readings = np.clip(readings, -limits[:, None], limits[:, None])
    steps = heard.steps[:, None]
    readings = np.round(readings / steps) * steps
    return Simulated(
        case,
        recording_of(case, heard, readings),
        heard.truth.T,
        heard.nominal.T,
        heard.reported.T,
        sealed_of(case, heard),
    )


def sealed_of(case: Case, heard: Heard) -> dict[str, Any]:
    """The truth as plain data: every parameter in SI with its unit."""
    return {
        "case": case.model_dump(mode="json"),
        "effects": {effect.name: dict(effect.parameters) for effect in heard.effects},
        "units": {effect.name: dict(effect.units) for effect in heard.effects},
        "grade": case.grade,
        "parameters": heard.unit.parameters(),
    }


def _noise(case: Case, count: int) -> np.ndarray:
    """(6, n): every channel its own, the same whatever the effects."""
    return np.stack([
        noise(generator(case.seed, f"noise {channel}"), model, count, case.rate_hz)
        for channel, model in enumerate(channel_noise(case.grade))
    ])  # fmt: skip
