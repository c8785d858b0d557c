"""The site in the manifest: consistent, shown by the unit, and the laboratory's own."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from schemas.recording import AXES, Recording, Segment, Stream
from schemas.text import Remark
from tasks.motion.table import EARTH_RATE
from tasks.motion.whole import unit_vector
from tasks.run_validity.remark import run_remark
from tasks.segments.find import Conditions
from tasks.segments.summarise import CHANNELS, SegmentMean
from tasks.specifications.course import following
from tasks.specifications.evidence import ClauseEvidence, birge_ratio, solve

# Air, supply and temperature of the unit: recorded over the whole run, and within limits.

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


LEVEL_PART, GRAVITY, PARAMETERS = slice(0, 2), slice(3, 6), 6  # north, east, zero, three axes up
KNOWN = 10.0  # Earth rates: what is less certain hangs on rounding alone
LATITUDE_DEG = 0.1  # two figures of one place, each rounded
EQUATOR, RISE, FLATTENING = 9.7803253359, 0.00193185265241, 0.00669437999014  # WGS 84
PER_METRE = 3.086e-6  # 1/s²: free-air gradient
ANOMALY = 0.003  # m/s²: what the ground does to it, 300 mGal, but for a few places at sea
INHABITED = (-430.0, 5500.0)  # m, where a laboratory may stand
BY_PRESSURE = 500.0  # m that the weather shifts a height read off the air's pressure
CONTRADICTED = 16.0  # χ² of two degrees of freedom: once in 3,000 good runs
SIGN = 0.00135  # one-sided, as three standard deviations: that good runs differ by so much
BEYOND_DOUBT = 10.0  # standard deviations from which it is no remark, but an invalid run


@dataclass(frozen=True)
class EarthRate:
    """level: (2,) along north and east, with its covariance (2, 2); NaN where not determined.

    vertical: along up, and how far the unit's own sensitivity to gravity may shift it, by so many
    degrees of freedom; NaN where not determined.
    """

    level: np.ndarray
    covariance: np.ndarray
    vertical: float
    u_vertical: float
    degrees: int

    def chi2(self, expected: np.ndarray) -> float:
        """How far the level part (2,) is from one that is expected."""
        away = self.level - expected
        return float(away @ np.linalg.solve(self.covariance, away))


def site_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Gravity that no place of that latitude and height has, and an Earth that turns otherwise."""
    yield from _gravity(evidence)
    if evidence.latitude_deg is None:
        yield run_remark("latitude_not_given")
        return
    if not evidence.tells_of_site:
        return
    shown = earth_rate(evidence)
    if shown is not None:
        yield from _level(shown, evidence.latitude_deg)
        yield from _vertical(shown, evidence.latitude_deg)


def _gravity(evidence: ClauseEvidence) -> Iterator[Remark]:
    """The local gravity against the normal one."""
    if evidence.gravity is None:
        yield run_remark("gravity_not_given")
        return
    latitude = evidence.latitude_deg
    heights = _heights(evidence)
    at = [normal_gravity(phi) for phi in ((0.0, 90.0) if latitude is None else (latitude,))]
    low = min(at) - PER_METRE * heights[1] - ANOMALY
    high = max(at) - PER_METRE * heights[0] + ANOMALY
    if not low <= evidence.gravity <= high:
        yield run_remark(
            "gravity_contradicted", run="invalid", gravity=f"{evidence.gravity:.5f}",
            latitude="–" if latitude is None else f"{latitude:g}", low=f"{low:.4f}",
            high=f"{high:.4f}", lowest=f"{heights[0]:.0f}", highest=f"{heights[1]:.0f}",
        )  # fmt: skip


def normal_gravity(latitude_deg: float) -> float:
    """Gravity at sea level, m/s² (Somigliana's formula, WGS 84)."""
    square = float(np.sin(np.radians(latitude_deg))) ** 2
    return EQUATOR * (1.0 + RISE * square) / float(np.sqrt(1.0 - FLATTENING * square))


def _heights(evidence: ClauseEvidence) -> tuple[float, float]:
    """Lowest and highest height (m) by the manifest, by the air's pressure, else of any place."""
    height = evidence.recording.manifest.station.height_m
    if height is not None:
        return height, height
    _, pressure = readings(evidence.recording.environment, "pressure")
    if not len(pressure):
        return INHABITED
    by_air = 44_330.0 * (1.0 - (float(np.median(pressure)) / 1013.25) ** 0.1903)
    return by_air - BY_PRESSURE, by_air + BY_PRESSURE


def _level(shown: EarthRate, latitude_deg: float) -> Iterator[Remark]:
    """The level part points north and is as long as the latitude has it."""
    expected = np.array([np.cos(np.radians(latitude_deg)), 0.0])
    if not np.isfinite(shown.level).all() or shown.chi2(expected) < CONTRADICTED:
        return
    north, east = shown.level
    absent = shown.chi2(np.zeros(2)) < CONTRADICTED
    sure = not absent and shown.chi2(expected) > BEYOND_DOUBT**2
    yield run_remark(
        "earth_not_shown" if absent else "earth_contradicted",
        run="invalid" if sure else "remarks",
        north=f"{north:.2f}", east=f"{east:.2f}", expected=f"{expected[0]:.2f}",
        u=f"{np.sqrt(np.diag(shown.covariance)).max():.2f}", latitude=f"{latitude_deg:g}",
    )  # fmt: skip


def _vertical(shown: EarthRate, latitude_deg: float) -> Iterator[Remark]:
    """The vertical part has the sign of the latitude.

    A sensitivity to gravity common to all three gyros cannot be separated from it: their common
    part is expected to be no larger than their differences.
    """
    from scipy.special import stdtrit  # late: a tenth of a start

    expected = float(np.sin(np.radians(latitude_deg)))
    as_given, otherwise = abs(shown.vertical - expected), abs(shown.vertical + expected)
    reach = shown.u_vertical * float(stdtrit(max(shown.degrees, 1), 1.0 - SIGN))
    if as_given > reach and otherwise < as_given:
        sure = as_given > max(BEYOND_DOUBT * shown.u_vertical, reach)
        yield run_remark(
            "latitude_sign", run="invalid" if sure else "remarks", latitude=f"{latitude_deg:g}",
            shown=f"{shown.vertical:+.2f}", expected=f"{expected:+.2f}",
            u=f"{shown.u_vertical:.2f}",
        )  # fmt: skip


def laboratory_remarks(recording: Recording, latitude_deg: float | None) -> Iterator[Remark]:
    """A latitude other than the laboratory's; nothing if it does not state its own.

    The gyros of many units do not show Earth's rotation, and then nothing in the data reveals it.
    """
    stated = recording.manifest.station.latitude_deg
    if stated is None or latitude_deg is None:
        return
    if abs(stated - latitude_deg) > LATITUDE_DEG:
        yield run_remark(
            "laboratory_latitude", run="invalid", latitude=f"{stated:g}", own=f"{latitude_deg:g}"
        )


def earth_rate(evidence: ClauseEvidence) -> EarthRate | None:
    """By least squares over the rests: zero, sensitivity to gravity, and the level part of each.

    None where fewer rests than that have a gyro and a known attitude. A scale factor of 1 is taken.
    """
    rests = [
        i
        for i in evidence.of_kind("static")
        if evidence.segments[i].has_gyro and evidence.up[i] is not None
    ]
    north = evidence.north[rests]
    if len(rests) <= PARAMETERS or not np.isfinite(north).all():
        return None
    up = np.array([unit_vector(evidence.up[i]) for i in rests])
    east = np.cross(north, up)
    weight, weighted, sensitivity = np.zeros((2, 2)), np.zeros(2), np.full((3, 3), np.nan)
    spread_of = np.full((3, 3), np.nan)
    for c in range(3):
        design = np.column_stack([north[:, c], east[:, c], np.ones(len(rests)), up])
        solution = solve(design)
        readings = evidence.means[rests, c] / EARTH_RATE
        covariance = evidence.covariance(c)[np.ix_(rests, rests)] / EARTH_RATE**2
        excess = birge_ratio(solution, design, readings, covariance).factor
        values, used = solution.of(readings), np.flatnonzero(solution.estimable[LEVEL_PART])
        u = excess * solution.uncertainty(covariance)[GRAVITY]
        sensitivity[c] = np.where(u < KNOWN, values[GRAVITY], np.nan)
        spread_of[c] = u
        operator = solution.operator[used]
        spread = excess**2 * operator @ covariance @ operator.T
        if len(used) and np.linalg.det(spread) > 0.0:
            of_gyro = np.linalg.inv(spread)
            weight[np.ix_(used, used)] += of_gyro
            weighted[used] += of_gyro @ values[used]
    level, by_all = np.full(2, np.nan), np.full((2, 2), np.nan)
    if np.linalg.det(weight) > 0.0:
        by_all = np.linalg.inv(weight)
        level = by_all @ weighted
    return EarthRate(level, by_all, *_common_part(sensitivity, np.diag(spread_of)))


def _common_part(sensitivity: np.ndarray, u: np.ndarray) -> tuple[float, float, int]:
    """What the diagonal has in common, the standard deviation that the rest and its own uncertainty
    u (3,) give it, and by how many degrees of freedom."""
    diagonal = np.diag(sensitivity)
    apart = np.concatenate(
        [sensitivity[~np.eye(3, dtype=bool)], np.sqrt(1.5) * (diagonal - diagonal.mean())]
    )
    apart = apart[np.isfinite(apart)]
    spread = float(np.sqrt(np.mean(apart**2) / 3.0)) if len(apart) else float("nan")
    total = float(np.sqrt(spread**2 + np.mean(u**2)))  # rounding is one to all three
    return float(diagonal.mean()), total, max(len(apart) - 1, 1)
