"""The air: recorded over the whole run, within the specification's limits."""

from collections.abc import Iterator

from schemas.text import Remark
from tasks.run_validity.covered import not_covered, readings, within
from tasks.run_validity.remark import run_remark
from tasks.segments.conditions import Conditions
from tasks.specifications.evidence import ClauseEvidence

UNITS = {"temperature": "°C", "humidity": "%RH"}


def environment_remarks(evidence: ClauseEvidence, conditions: Conditions) -> Iterator[Remark]:
    """Air temperature and humidity that were not recorded, or left their limits."""
    air, clause = evidence.recording.environment, conditions.environment_clause
    if not set(UNITS) <= set(air.columns if air is not None else {}):
        yield run_remark("environment_not_recorded", clause=clause)
    limits = {"temperature": conditions.temperature_degc, "humidity": conditions.humidity_percent}
    for column, (low, high) in limits.items():
        t, values = readings(air, column)
        bare = not_covered(t, evidence.segments)
        if bare and air is not None and column in air.columns:
            yield run_remark(
                "environment_in_part", *bare, quantity=column, clause=clause,
                count=len(bare), of=len(evidence.segments), first=bare[0],
            )  # fmt: skip
        for segment in evidence.segments:
            here = within(t, values, (segment,))
            if not len(here) or (here.min() >= low and here.max() <= high):
                continue
            name = segment.segment.name
            yield run_remark(
                "environment", name, run="invalid", segment=name, quantity=column,
                unit=UNITS[column], low=f"{low:g}", high=f"{high:g}", clause=clause,
                worst=f"{here.max() if here.max() > high else here.min():.1f}",
            )  # fmt: skip
