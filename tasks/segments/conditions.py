"""What a specification asks of every point and of the environment, and remarks on the latter."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from schemas.recording import Recording
from schemas.text import Remark
from tasks.segments.summarise import SegmentMean
from tasks.words import Argument, message, remark

UNITS = {"temperature": "°C", "humidity": "%RH"}


@dataclass(frozen=True)
class Conditions:
    """Numbers of a specification and the clauses they come from.

    dwell_s: least time at each point, s. steadiness: relative change of a held rate.
    temperature_degc, humidity_percent: lowest and highest value of the air.
    """

    dwell_s: float
    dwell_clause: str
    steadiness: float
    steadiness_clause: str
    temperature_degc: tuple[float, float]
    humidity_percent: tuple[float, float]
    environment_clause: str


def segment_remark(
    code: str, *segments: str, blocks_pass: bool = True, **arguments: Argument
) -> Remark:
    """A remark on segments; its message is called «segments-» and its code."""
    text = message(f"segments-{code.replace('_', '-')}", **arguments)
    return remark(code, text, segments, blocks_pass=blocks_pass)


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
    name, rows = segment.segment.name, recording.environment.rows(segment.t_start, segment.t_end)
    for column, (low, high) in limits.items():
        values = recording.environment.columns.get(column, np.empty(0))[rows]
        if not len(values) or (values.min() >= low and values.max() <= high):
            continue
        yield segment_remark(
            "environment", name, segment=name, quantity=column, unit=UNITS[column],
            worst=f"{values.max() if values.max() > high else values.min():.1f}",
            low=f"{low:g}", high=f"{high:g}", clause=conditions.environment_clause,
        )  # fmt: skip


def environment_not_recorded(recording: Recording, conditions: Conditions) -> Iterator[Remark]:
    """Where temperature or humidity was not recorded at all."""
    recorded = recording.environment.columns if recording.environment is not None else {}
    if not set(UNITS) <= set(recorded):
        yield segment_remark("environment_not_recorded", clause=conditions.environment_clause)
