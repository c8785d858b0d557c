"""Simulated units and equipment, drawn from what the uncertainty budgets claim."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from schemas.recording import Manifest, Recording, Standard, Stream
from tasks.station.virtual.config import THREE_AXES
from tasks.station.virtual.sensors import SensorNoise
from tasks.station.virtual.unit import UnitTruth, draw_unit
from tasks.uncertainty.distributions import draw
from tasks.uncertainty.equipment import ErrorLimit
from tasks.validation.simulated_calibration import Journey, Site

GRAVITY, LATITUDE = 9.8015, float(np.radians(39.9))  # what the manifest says
NO_FLICKER = 0.25  # share of the units that have white noise alone
FLICKER_GRADES = (0.1, 10.0)  # times the unit's usual flicker, evenly in its logarithm


@dataclass(frozen=True)
class SimulatedUnit:
    """One simulated unit, its random numbers, and whether noise and equipment are ideal."""

    unit: UnitTruth
    random: np.random.Generator
    ideal: bool = False

    def error(self, *limits: ErrorLimit | None) -> float:
        """Sum of errors drawn from the limits' distributions, in their unit; 0 when ideal."""
        if self.ideal:
            return 0.0
        drawn = (limit.u * draw(limit.distribution, 1, self.random)[0] for limit in limits if limit)
        return float(sum(drawn))

    def errors(self, count: int, *limits: ErrorLimit | None) -> np.ndarray:
        """Independent errors (count,)."""
        return np.array([self.error(*limits) for _ in range(count)])

    def site(self, gravity: ErrorLimit, latitude: ErrorLimit) -> Site:
        """Where it truly is; the manifest says GRAVITY and LATITUDE."""
        return Site(GRAVITY + self.error(gravity), LATITUDE + self.error(latitude))

    def noise(self) -> SensorNoise | None:
        """The noise of the unit; None when ideal."""
        return None if self.ideal else SensorNoise(self.unit)


def draw_simulated_unit(seed: int, rate_hz: float, ideal: bool = False) -> SimulatedUnit:
    """A unit of the virtual station, with a grade of flicker of its own.

    A quarter of the units have white noise alone, as often as not in either triad.
    """
    unit = draw_unit(seed)
    random = np.random.default_rng(np.random.SeedSequence((seed, 2)))
    triads = {}
    for name in ("gyro", "accel"):
        triad = getattr(unit, name)
        low, high = np.log(FLICKER_GRADES)
        grade = float(np.exp(random.uniform(low, high))) * (random.random() >= NO_FLICKER)
        triads[name] = triad.model_copy(update={"flicker": triad.flicker * grade})
    return SimulatedUnit(unit.model_copy(update={**triads, "rate_hz": rate_hz}), random, ideal)


def recording_of(
    standard: Standard,
    number: int,
    journey: Journey,
    imu: Mapping[str, np.ndarray],
    table_angles: np.ndarray | None = None,
) -> Recording:
    """A journey as a recording: columns (n,) of the unit, and table angles (3, n) where recorded.

    The air is within the conditions, one row in ten seconds.
    """
    name = "AHRS" if standard == "JJF 1536-2015" else "MIMU"
    axes = {} if table_angles is None else {"table_axes": THREE_AXES}
    manifest = Manifest.model_validate({
        "format": "mimu-recording/1", "recording_id": f"simulated-{standard[4:8]}-{number}",
        "standard": standard,
        "unit": {"manufacturer": "Virtual", "model": f"V-{name}", "serial": f"S{number}"},
        "station": {"id": "simulated", "gravity_m_s2": GRAVITY, "heading_deg": 0.0,
                    "latitude_deg": float(np.degrees(LATITUDE)), **axes},
        "segments": journey.segments,
    })  # fmt: skip
    t = np.arange(len(next(iter(imu.values())))) / journey.rate_hz
    seconds = np.arange(0.0, t[-1], 10.0)
    air = {"temperature": np.full(len(seconds), 20.0), "humidity": np.full(len(seconds), 45.0)}
    table = None
    if table_angles is not None:
        names = (f"{axis.name}_angle" for axis in THREE_AXES)
        table = Stream(t, dict(zip(names, table_angles, strict=True)))
    return Recording(
        manifest, Stream(t, imu), table=table, environment=Stream(seconds, air), digest="0" * 64
    )
