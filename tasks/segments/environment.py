"""Checks of the environment: air temperature and humidity against the specification's limits."""

from collections.abc import Iterator

import numpy as np

from schemas.recording import Recording
from schemas.text import Remark
from tasks.segments.conditions import Conditions
from tasks.segments.summarise import SegmentMean
from tasks.words import message, remark

UNITS = {"temperature": "°C", "humidity": "%RH"}


def environment_remarks(
    recording: Recording, segment: SegmentMean, conditions: Conditions
) -> Iterator[Remark]:
    """Air temperature and humidity outside the specification's limits during the segment."""
    if recording.environment is None:
        return
    limits = {
        "temperature": conditions.temperature_degc,
        "humidity": conditions.humidity_percent,
    }
    rows = recording.environment.rows(segment.t_start, segment.t_end)
    for column, (low, high) in limits.items():
        values = recording.environment.columns.get(column, np.empty(0))[rows]
        if not len(values) or (values.min() >= low and values.max() <= high):
            continue
        text = message(
            "segments-environment", segment=segment.segment.name,
            quantity=message(f"segments-{column}"),
            worst=f"{values.max() if values.max() > high else values.min():.1f}",
            unit=UNITS[column], low=f"{low:g}", high=f"{high:g}",
            clause=conditions.environment_clause,
        )  # fmt: skip
        yield remark("environment", text, (segment.segment.name,), blocks_pass=True)


def environment_not_recorded(recording: Recording, conditions: Conditions) -> Iterator[Remark]:
    """Where temperature or humidity was not recorded at all."""
    recorded = recording.environment.columns if recording.environment is not None else {}
    if not set(UNITS) <= set(recorded):
        clause = conditions.environment_clause
        text = message("segments-environment-not-recorded", clause=clause)
        yield remark("environment_not_recorded", text, blocks_pass=True)
