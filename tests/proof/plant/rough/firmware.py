"""What firmware does to the numbers: ranges, axes, dead zones, codes, limits."""

from dataclasses import replace
from typing import ClassVar

import numpy as np

from tests.proof.plant.effects.base import Parameters
from tests.proof.plant.rough.logged import TRIADS, Logged, Rows, some_triad
from tests.proof.plant.world import Setting


class RangeSetting(Logged):
    """A triad is wrong by one factor: range bits, degrees for radians, g for m/s², a neighbour's
    counts per unit."""

    name = form = "range_setting"
    units: ClassVar = {"triad": "", "factor": "1"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        triad = some_triad(rng)
        unit = 180.0 / np.pi if triad == "gyro" else 1.0 / 9.80665
        neighbour = 16.4 / 14.375  # counts per deg/s of two makers at the same range
        return {"triad": triad, "factor": float(rng.choice([0.25, 0.5, 2.0, 4.0, neighbour, unit]))}

    def logged(self, rows: Rows) -> Rows:
        readings = rows.readings.copy()
        readings[TRIADS[self.parameters["triad"]]] *= self.parameters["factor"]
        return replace(rows, readings=readings)


class AxisMapping(Logged):
    """Axes of a triad exchanged or inverted: what is written as axis i is sign_i · reading
    order_i."""

    name = form = "axis_mapping"
    units: ClassVar = {"triads": "", "order": "1", "sign": "1"}
    CHOICES: ClassVar = (
        ([1, 0, 2], [1, 1, 1]), ([1, 0, 2], [1, 1, -1]), ([0, 1, 2], [-1, 1, 1]),
        ([0, 1, 2], [1, 1, -1]), ([2, 0, 1], [1, 1, 1]), ([0, 2, 1], [1, -1, 1]),
    )  # fmt: skip

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        order, sign = cls.CHOICES[int(rng.integers(len(cls.CHOICES)))]
        return {"triads": [some_triad(rng)], "order": order, "sign": sign}

    def logged(self, rows: Rows) -> Rows:
        readings = rows.readings.copy()
        for triad in self.parameters["triads"]:
            written = readings[TRIADS[triad]][self.parameters["order"]]
            readings[TRIADS[triad]] = written * self.column("sign")
        return replace(rows, readings=readings)


class DeadZone(Logged):
    """The firmware writes gyro readings below a threshold as zero."""

    name = form = "dead_zone"
    units: ClassVar = {"threshold": "rad/s"}
    sized: ClassVar[tuple[str, ...]] = ("threshold",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"threshold": 0.03}

    def logged(self, rows: Rows) -> Rows:
        readings = rows.readings.copy()
        gyros = readings[:3]
        gyros[np.abs(gyros) < self.parameters["threshold"]] = 0.0
        return replace(rows, readings=readings)


class BiasAtRest(Logged):
    """The firmware takes the gyros' bias off while it believes that the unit rests.

    At rest: for `wait` s no gyro left ± `quiet` about its own estimate. The estimate then follows
    the readings, with `tau`; it starts at zero.
    """

    name, form = "dead_zone", "dead_zone_bias_at_rest"
    units: ClassVar = {"wait": "s", "quiet": "rad/s", "tau": "s"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"wait": float(rng.uniform(0.5, 1.5)), "quiet": 0.05,
                "tau": float(rng.uniform(0.3, 1.5))}  # fmt: skip

    def logged(self, rows: Rows) -> Rows:
        step = float(np.median(np.diff(rows.stamp)))
        keep = float(np.exp(-step / self.parameters["tau"]))
        needed, quiet = int(self.parameters["wait"] / step), self.parameters["quiet"]
        bias, still = np.zeros(3), 0
        written = rows.readings.copy()
        for row, reading in enumerate(rows.readings[:3].T):
            still = still + 1 if np.abs(reading - bias).max() < quiet else 0
            if still > needed:
                bias = keep * bias + (1.0 - keep) * reading
            written[:3, row] = reading - bias
        return replace(rows, readings=written)


class StuckBit(Logged):
    """One bit of a channel's code is stuck: the error is 0 or one weight, by the code."""

    name, form = "code_fault", "code_fault_stuck_bit"
    units: ClassVar = {"channel": "1", "bit": "1", "level": "1"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"channel": int(rng.integers(6)), "bit": int(rng.integers(5, 8)),
                "level": int(rng.integers(2))}  # fmt: skip

    def logged(self, rows: Rows) -> Rows:
        channel, bit = self.parameters["channel"], 1 << self.parameters["bit"]
        readings = rows.readings.copy()
        code = np.rint(readings[channel] / rows.step[channel]).astype(int)
        code = code | bit if self.parameters["level"] else code & ~bit
        readings[channel] = code * rows.step[channel]
        return replace(rows, readings=readings)


class TornCode(Logged):
    """The high byte of a code is read before the low byte has moved on: where the low byte wraps
    between two samples, a share of the readings is off by 256 counts."""

    name, form = "code_fault", "code_fault_torn"
    units: ClassVar = {"triad": "", "share": "1"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"triad": some_triad(rng), "share": float(rng.uniform(0.3, 1.0))}

    def logged(self, rows: Rows) -> Rows:
        readings, rng = rows.readings.copy(), self.rng()
        for channel in range(6)[TRIADS[self.parameters["triad"]]]:
            code = np.rint(readings[channel] / rows.step[channel]).astype(int)
            before = np.roll(code, 1)
            torn = rng.uniform(size=len(code)) < self.parameters["share"]
            mixed = (before >> 8 << 8) + (code & 255)
            readings[channel] = np.where(torn, mixed, code) * rows.step[channel]
        return replace(rows, readings=readings)


class _Plateau(Logged):
    """Saturation ahead of the unit's own calibration: each axis and side stops elsewhere.

    The raw value is clipped at ± limit, the converter dithers it, then offset and cross-coupling
    are taken off, so that the plateau is a band of many values, not one code.
    """

    units: ClassVar = {"limit": "", "offset": "", "coupling": "1", "dither": "1"}
    sized: ClassVar[tuple[str, ...]] = ("limit",)
    before_codes: ClassVar = True
    triad: ClassVar[str]

    @classmethod
    def at(cls, typical: Parameters, strength: float) -> Parameters:
        """The limit falls as strength grows: from the largest reading to three tenths of it."""
        return typical | {"limit": typical["limit"] * float(max(np.exp(-0.4 * strength), 0.3))}

    @classmethod
    def of_largest(cls, rng: np.random.Generator, largest: float) -> Parameters:
        return {
            "limit": largest,
            "offset": (0.02 * largest * rng.standard_normal(3)).tolist(),
            "coupling": (0.01 * rng.standard_normal((3, 3))).tolist(),
            "dither": 5e-4,
        }

    def logged(self, rows: Rows) -> Rows:
        readings = rows.readings.copy()
        own, limit = TRIADS[self.triad], self.parameters["limit"]
        mixing = np.eye(3) + self.value("coupling") * (1.0 - np.eye(3))
        raw = np.linalg.solve(mixing, readings[own]) + self.column("offset")
        stopped = np.clip(raw, -limit, limit)
        dither = self.parameters["dither"] * limit * self.rng().standard_normal(raw.shape)
        stopped += np.where(stopped != raw, dither, 0.0)
        readings[own] = mixing @ (stopped - self.column("offset"))
        return replace(rows, readings=readings)


class GyroPlateau(_Plateau):
    """Gyros that stop ahead of their calibration."""

    name, form, triad = "gyro_saturation", "gyro_saturation_plateau", "gyro"

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return cls.of_largest(rng, setting.top_rate)


class AccelPlateau(_Plateau):
    """Accelerometers that stop ahead of their calibration."""

    name, form, triad = "accel_saturation", "accel_saturation_plateau", "accel"

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return cls.of_largest(rng, 1.05 * setting.case.gravity_m_s2)
