"""A short run on three axes, played once without noise for each set of effects."""

from functools import lru_cache
from typing import Any

from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import NoiseFree, without_noise

SHORT: dict[str, Any] = {"seed": 4, "dwell_s": 6.0, "rates_deg_s": (50.0, 200.0)}


def case_of(*effects: str, fields: dict[str, Any] | None = None, **parameters: Any) -> Case:
    """A short case: effect names with parameters, and fields of the case."""
    calls = tuple(EffectCall(name=name, parameters=parameters) for name in effects)
    return Case(**(SHORT | (fields or {})), effects=calls)


@lru_cache(maxsize=16)
def _noise_free(text: str) -> NoiseFree:
    return without_noise(Case.model_validate_json(text))


def noise_free(case: Case) -> NoiseFree:
    """Plays a case without noise; the same case only once."""
    return _noise_free(case.model_dump_json())


def in_segment(run: NoiseFree, name: str, margin: float = 1.0) -> slice:
    """The rows of a named segment, without its ends."""
    number = next(n for n, segment in enumerate(run.plan.segments) if segment.name == name)
    start, end = run.plan.bounds[number : number + 2]
    rate = 1.0 / (run.stamp[1] - run.stamp[0])
    return slice(int((start + margin) * rate), int((end - margin) * rate))
