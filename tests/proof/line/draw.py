"""Which units a line has, when each was run on which station, and which station was tilted."""

from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta

import numpy as np

from tests.proof.plant.case import Grade, UnitErrors, draw_unit

STATIONS, YEARS = 6, 3.0
BEGINNING = datetime(2023, 11, 1, 8, tzinfo=UTC)
MODELS: tuple[tuple[str, Grade], ...] = (
    ("MX-110", "industrial"), ("MX-120", "industrial"), ("MX-210", "consumer"),
    ("MX-400", "tactical"),
)  # fmt: skip
YEAR_D = 365.25
TILT_RAD = (0.8e-4, 1.6e-4)
DRIFT_BIAS = 2e-3, 8e-3  # rad/s and m/s² in a year, of gyro and accelerometer
DRIFT_SCALE = 1.5e-3  # in a year
OFF_SCALE = 8e-4  # by which the models' mean scale factors differ
NONE, SQUARE = np.zeros(3), np.zeros((3, 3))
IDEAL = UnitErrors(Kg=np.eye(3), Bg=NONE, G=SQUARE, Ka=np.eye(3), Ba=NONE, P=SQUARE)


@dataclass(frozen=True)
class Tilt:
    """A station whose base is no longer level. east, north: rad, the vector it was turned by."""

    station: int
    since: datetime
    east: float
    north: float


@dataclass(frozen=True)
class LineUnit:
    """A unit with its true coefficients at the beginning, and what they change by in a year."""

    number: int
    model: int
    at_first: UnitErrors
    drift: UnitErrors

    @property
    def serial(self) -> str:
        return f"SN{self.number:04d}"

    @property
    def grade(self) -> Grade:
        return MODELS[self.model][1]

    def after(self, years: float, kept: float) -> UnitErrors:
        """Its coefficients. kept: the share of what it had that its last adjustment left."""
        off = combined(self.at_first, IDEAL, -1.0)
        return combined(combined(IDEAL, off, kept), self.drift, years)


@dataclass(frozen=True)
class Line:
    """What determines a store. places: of the units' runs, drawn when a run is made."""

    seed: int
    runs: int
    units: tuple[LineUnit, ...]
    tilt: Tilt


def draw_line(seed: int, runs: int, units: int) -> Line:
    """A line of a seed with so many runs of so many units."""
    rng = np.random.default_rng([seed, 61])
    days = YEARS * YEAR_D * rng.uniform(0.35, 0.7)
    azimuth, size = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(*TILT_RAD)
    tilt = Tilt(
        station=int(rng.integers(STATIONS)),
        since=BEGINNING + timedelta(days=float(days)),
        east=size * float(np.cos(azimuth)),
        north=size * float(np.sin(azimuth)),
    )
    return Line(seed, runs, tuple(_unit(rng, number) for number in range(units)), tilt)


def combined(one: UnitErrors, other: UnitErrors, factor: float) -> UnitErrors:
    """one + factor·other, coefficient by coefficient."""
    sums = {name: getattr(one, name) + factor * getattr(other, name) for name in vars(one)}
    return UnitErrors(**sums)


def is_tilted(line: Line, station: int, at: datetime) -> bool:
    return station == line.tilt.station and at >= line.tilt.since


def station_name(number: int) -> str:
    return f"ST-{number + 1:02d}"


def _unit(rng: np.random.Generator, number: int) -> LineUnit:
    """Of its model's distribution: the plant's, about a mean scale factor of the model's own."""
    model = number % len(MODELS)
    mean = np.eye(3) * OFF_SCALE * (model - (len(MODELS) - 1) / 2.0)
    first = draw_unit(int(rng.integers(1, 2**31 - 1)))
    drift = UnitErrors(
        Kg=np.diag(DRIFT_SCALE * rng.standard_normal(3)),
        Bg=DRIFT_BIAS[0] * rng.standard_normal(3),
        G=SQUARE,
        Ka=np.diag(DRIFT_SCALE * rng.standard_normal(3)),
        Ba=DRIFT_BIAS[1] * rng.standard_normal(3),
        P=SQUARE,
    )
    first = replace(first, Kg=first.Kg + mean, Ka=first.Ka + mean)
    return LineUnit(number, model, first, drift)
