"""A short run on three axes, played once without noise for each set of effects."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import pytest

from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.noise_free_case import NoiseFree, without_noise

SHORT: dict[str, Any] = {"seed": 4, "dwell_s": 6.0, "rates_deg_s": (50.0, 200.0)}


@lru_cache(maxsize=16)
def _noise_free(text: str) -> NoiseFree:
    return without_noise(Case.model_validate_json(text))


@pytest.fixture(scope="session")
def case_of() -> Callable[..., Case]:
    """Builds a short case: effect names with parameters, and fields of the case."""

    def build(*effects: str, fields: dict[str, Any] | None = None, **parameters: Any) -> Case:
        calls = tuple(EffectCall(name=name, parameters=parameters) for name in effects)
        return Case(**(SHORT | (fields or {})), effects=calls)

    return build


@pytest.fixture(scope="session")
def noise_free() -> Callable[[Case], NoiseFree]:
    """Plays a case without noise; the same case only once."""
    return lambda case: _noise_free(case.model_dump_json())


@pytest.fixture(scope="session")
def in_segment() -> Callable[..., slice]:
    """Gives the rows of a named segment, without its ends."""

    def rows(noise_free: NoiseFree, name: str, margin: float = 1.0) -> slice:
        number = next(
            n for n, segment in enumerate(noise_free.plan.segments) if segment.name == name
        )
        start, end = noise_free.plan.bounds[number : number + 2]
        rate = 1.0 / (noise_free.stamp[1] - noise_free.stamp[0])
        return slice(int((start + margin) * rate), int((end - margin) * rate))

    return rows
