"""Air, supply and temperature of the unit: recorded over the whole run, and within limits."""

from collections.abc import Iterator

import numpy as np

from schemas.recording import AXES, Segment, Stream
from schemas.text import Remark
from tasks.run_validity.remark import run_remark
from tasks.segments.conditions import Conditions
from tasks.segments.summarise import CHANNELS, SegmentMean
from tasks.specifications.course import following
from tasks.specifications.evidence import ClauseEvidence

COOLER, WARMER = 10.0, 40.0  # K from the air: a unit heats itself, and nothing cools it
LARGEST_CHANGE = 15.0  # K while it is measured: what warming up leaves
SUPPLY_STEADY = 0.05  # of the usual voltage, in either direction
SUPPLY_V = (1.0, 60.0)  # V: nothing else supplies an inertial unit
SHARE_COVERED = 0.05  # of the run: farther from a reading nothing is known
LEAST, MOST = 10.0, 300.0  # s, whatever the run's length: a logger's interval, a room's drift
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


def readings(stream: Stream | None, column: str) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) s and values (n,) of a column where it was recorded."""
    if stream is None or column not in stream.columns:
        return np.empty(0), np.empty(0)
    values = stream.columns[column]
    known = np.isfinite(values)
    return stream.t[known], values[known]


def not_covered(t: np.ndarray, segments: tuple[SegmentMean, ...]) -> list[str]:
    """The names of the segments with a time that is far from every reading at t (n,) s."""
    if not segments:
        return []
    begin, end = min(s.t_start for s in segments), max(s.t_end for s in segments)
    reach = float(np.clip(SHARE_COVERED * (end - begin), LEAST, MOST))
    return [s.segment.name for s in segments if _farthest(t, s.segment, reach) > reach]


def _farthest(t: np.ndarray, segment: Segment, reach: float) -> float:
    """How far (s) from a reading the segment gets."""
    if not len(t):
        return float("inf")
    asked = np.append(np.arange(segment.t_start, segment.t_end, reach / 4), segment.t_end)
    after = np.clip(np.searchsorted(t, asked), 0, len(t) - 1)
    before = np.maximum(after - 1, 0)
    return float(np.minimum(np.abs(t[after] - asked), np.abs(t[before] - asked)).max())


def within(t: np.ndarray, values: np.ndarray, segments: tuple[SegmentMean, ...]) -> np.ndarray:
    """The values at times t (n,) s that lie in a segment."""
    edges = np.array([(s.t_start, s.t_end) for s in segments]).reshape(-1, 2)
    rows = np.searchsorted(t, edges)
    return np.concatenate([values[start:stop] for start, stop in rows] or [np.empty(0)])


def supply_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """A supply that is unknown, fell, rose, or is implausible."""
    t, values = readings(evidence.recording.environment, "supply_voltage")
    bare = not_covered(t, evidence.segments)
    if bare:
        yield run_remark("supply_not_recorded", *bare, count=len(bare), of=len(evidence.segments))
    volts = within(t, values, evidence.segments)
    if not len(volts):
        return
    low, usual, high = float(volts.min()), float(np.median(volts)), float(volts.max())
    if not SUPPLY_V[0] <= usual <= SUPPLY_V[1]:
        yield run_remark(
            "supply_level", run="invalid", level=f"{usual:.2f}", low=f"{SUPPLY_V[0]:g}",
            high=f"{SUPPLY_V[1]:g}",
        )  # fmt: skip
    elif max(high - usual, usual - low) > SUPPLY_STEADY * usual:
        yield run_remark(
            "supply_changed", run="invalid", low=f"{low:.2f}", high=f"{high:.2f}",
            usual=f"{usual:.2f}", percent=f"{100 * SUPPLY_STEADY:g}",
        )  # fmt: skip


def unit_temperature_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """A temperature of the unit that is not known, far from the air's, or changed."""
    recording, segments = evidence.recording, evidence.segments
    t, values = readings(recording.imu, "temperature")
    bare = not_covered(t, segments)
    if bare:
        yield run_remark(
            "unit_temperature_not_recorded", *bare, count=len(bare), of=len(segments),
        )  # fmt: skip
    yield from _followed(evidence)
    seen = [np.median(part) for s in segments if len(part := within(t, values, (s,)))]
    if not seen:
        return
    low, high = float(min(seen)), float(max(seen))
    if high - low > LARGEST_CHANGE:
        yield run_remark(
            "unit_temperature_changed", run="invalid", low=f"{low:.1f}", high=f"{high:.1f}",
            limit=f"{LARGEST_CHANGE:g}",
        )  # fmt: skip
    air = within(*readings(recording.environment, "temperature"), segments)
    if not len(air):
        return
    around = float(np.median(air))
    if not around - COOLER <= float(np.median(seen)) <= around + WARMER:
        yield run_remark(
            "unit_temperature_level", run="invalid", level=f"{np.median(seen):.1f}",
            air=f"{around:.1f}", cooler=f"{COOLER:g}", warmer=f"{WARMER:g}",
        )  # fmt: skip


def _followed(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Channels whose readings follow the recorded temperature of the unit, by how much in 1 K."""
    for c, name in enumerate(CHANNELS):
        values = following(evidence, c)
        if values is not None:
            yield run_remark(
                "follows_temperature", run="valid", channel=name,
                change=f"{np.ptp(evidence.temperatures):.2g}",
                gain=f"{1e6 * values[2] / values[0]:+.0f}", zero=f"{values[3]:+.2g}",
                unit="rad/s" if c < len(AXES) else "m/s2",
            )  # fmt: skip
