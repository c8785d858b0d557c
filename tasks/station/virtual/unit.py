"""The true errors of a unit under test: drawn from a seed and hidden from its calibration."""

from typing import Any, Literal

import numpy as np
from pydantic import Field

from schemas.base import Finite, Frozen
from schemas.recording import Vector

Matrix = tuple[Vector, Vector, Vector]
DEGREE = float(np.pi / 180.0)
G = 9.80665  # m/s², the standard value: a unit for drawing sizes, not the gravity at the station


class TriadTruth(Frozen):
    """Three like sensors. In units of the triad's quantity: rad/s or m/s²."""

    scale: Matrix
    bias: Vector
    bias_per_kelvin: Vector
    bandwidth_hz: Finite = Field(gt=0)
    white: Finite = Field(ge=0, description="random walk: density, per √Hz")
    flicker: Finite = Field(ge=0, description="standard deviation of each relaxation")
    full_scale: Finite = Field(gt=0)
    lsb: Finite = Field(gt=0)


class UnitTruth(Frozen):
    """A strapdown unit. Matrix rows are the sensors that read, columns the body axes.

    gyro, accel: the two triads. g_sensitivity: (rad/s) per (m/s²). places_m: where each
    accelerometer sits, from the intersection of the table's axes, in the body frame. The
    biases hold at `settled_degc`; the unit warms up toward the air plus `self_heating_k`.
    angle_lsb: rad in a count, of a unit that accumulates angles (an AHRS). label: its serial number
    where that is not made of the seed.
    """

    seed: int
    label: str | None = None
    gyro: TriadTruth
    accel: TriadTruth
    g_sensitivity: Matrix
    places_m: Matrix
    angle_lsb: Finite | None = Field(default=None, gt=0)
    rate_hz: Finite = Field(default=100.0, gt=0, le=1000)
    clock_offset_s: Finite = Field(default=0.0, ge=0, description="station time at power-on")
    clock_skew: Finite = Field(default=0.0, description="the unit's clock runs 1 + skew")
    self_heating_k: Finite = 8.0
    heating_time_s: Finite = Field(default=120.0, gt=0)
    settled_degc: Finite = 28.0

    @property
    def frame(self) -> Literal["rates", "angles"]:
        """The frame that it sends, of tasks.station.virtual.protocol.FRAMES."""
        return "rates" if self.angle_lsb is None else "angles"

    @property
    def serial(self) -> str:
        """Its serial number, which it tells whoever asks."""
        return self.label or f"{'V' if self.angle_lsb is None else 'A'}{self.seed:05d}"

    @property
    def rate_sensitivity_m(self) -> np.ndarray:
        """The P of model (2) of JJF 2003 that the places imply: (3, 3), m.

        A turn ω about body axis j gives the point r the acceleration −ω²·(r − (r·e_j)·e_j);
        accelerometer i takes it through its row of the scale matrix.
        """
        parts = np.array(self.accel.scale) * np.array(self.places_m)
        return parts - parts.sum(axis=1, keepdims=True)


def draw_ahrs(seed: int) -> UnitTruth:
    """A unit that accumulates angles, with better gyros; the same for the same seed."""
    unit = draw_unit(seed)
    rng = np.random.default_rng(np.random.SeedSequence((seed, 2)))
    errors = rng.normal(0.0, 1.0, (3, 3)) * np.where(np.eye(3, dtype=bool), 3e-4, 8e-4)
    better = {
        "scale": (np.eye(3) + errors).tolist(),
        "bias": rng.normal(0.0, 2e-3 * DEGREE, 3).tolist(),
        "bias_per_kelvin": rng.normal(0.0, 2e-5 * DEGREE, 3).tolist(),
        "white": 1e-5,
        "flicker": 5e-7,
    }
    level = {"bias": rng.normal(0.0, 3e-3 * G, 3).tolist()}
    values = unit.model_dump() | {
        "gyro": unit.gyro.model_dump() | better,
        "accel": unit.accel.model_dump() | level,
        "g_sensitivity": np.zeros((3, 3)).tolist(),
        "angle_lsb": 1e-5 * DEGREE,
        "rate_hz": 10.0,
    }
    return UnitTruth.model_validate(values)


def draw_unit(seed: int) -> UnitTruth:
    """An industrial MEMS unit, the same for the same seed."""
    rng = np.random.default_rng(seed)

    def vector(size: float) -> Any:
        return rng.normal(0.0, size, 3).tolist()

    def square(diagonal: float, rest: float) -> np.ndarray:
        drawn = rng.normal(0.0, 1.0, (3, 3))
        return drawn * np.where(np.eye(3, dtype=bool), diagonal, rest)

    gyro = TriadTruth(
        scale=(np.eye(3) + square(3e-3, 2e-3)).tolist(),
        bias=vector(0.2 * DEGREE),
        bias_per_kelvin=vector(5e-4 * DEGREE),
        bandwidth_hz=40.0,
        white=5e-5,
        flicker=5e-6,
        full_scale=500.0 * DEGREE,
        lsb=500.0 * DEGREE / 2**19,
    )
    accel = TriadTruth(
        scale=(np.eye(3) + square(3e-3, 2e-3)).tolist(),
        bias=vector(0.03 * G),
        bias_per_kelvin=vector(5e-5 * G),
        bandwidth_hz=50.0,
        white=100e-6 * G,
        flicker=1e-5 * G,
        full_scale=10.0 * G,
        lsb=10.0 * G / 2**19,
    )
    sensitivity = square(1e-3, 1e-3) * DEGREE / G
    places = rng.uniform(-1e-3, 1e-3, (3, 3))
    return UnitTruth(
        seed=seed,
        gyro=gyro,
        accel=accel,
        g_sensitivity=sensitivity.tolist(),
        places_m=places.tolist(),
    )
