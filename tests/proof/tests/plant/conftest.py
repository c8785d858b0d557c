"""A short run on three axes, heard once for each set of effects."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import pytest

from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.hearing import Heard, hear

SHORT: dict[str, Any] = {"seed": 4, "dwell_s": 6.0, "rates_deg_s": (50.0, 200.0)}


@lru_cache(maxsize=16)
def _heard(text: str) -> Heard:
    return hear(Case.model_validate_json(text))


@pytest.fixture(scope="session")
def case_of() -> Callable[..., Case]:
    """Builds a short case: effect names with parameters, and fields of the case."""

    def build(*effects: str, fields: dict[str, Any] | None = None, **parameters: Any) -> Case:
        calls = tuple(EffectCall(name=name, parameters=parameters) for name in effects)
        return Case(**(SHORT | (fields or {})), effects=calls)

    return build


@pytest.fixture(scope="session")
def heard() -> Callable[[Case], Heard]:
    """Plays a case without noise; the same case only once."""
    return lambda case: _heard(case.model_dump_json())


@pytest.fixture(scope="session")
def in_segment() -> Callable[..., slice]:
    """Gives the rows of a named leg, without its ends."""

    def rows(heard: Heard, name: str, margin: float = 1.0) -> slice:
        number = next(n for n, leg in enumerate(heard.plan.legs) if leg.name == name)
        start, end = heard.plan.bounds[number : number + 2]
        rate = 1.0 / (heard.stamp[1] - heard.stamp[0])
        return slice(int((start + margin) * rate), int((end - margin) * rate))

    return rows
