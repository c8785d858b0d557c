"""Effects that act on the rows of the log, behind the sensors."""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from tests.proof.plant.case import generator
from tests.proof.plant.effects import EFFECTS, effects_of
from tests.proof.plant.effects.base import Effect, Following, Parameters, unit_vector
from tests.proof.plant.effects.environment import both
from tests.proof.plant.effects.memory import in_one_direction
from tests.proof.plant.effects.outside import lagged
from tests.proof.plant.effects.sensors import STANDARD_G, VibrationRectification, signs
from tests.proof.plant.rough.runs import RoughSetting, scattered
from tests.proof.plant.simulate import fine_rate
from tests.proof.plant.world import REFERENCE, Setting, World, on_accelerometers, on_gyros

TRIADS = {"gyro": slice(0, 3), "accel": slice(3, 6)}


@dataclass(frozen=True)
class Rows:
    """stamp: (n,) s. readings: (6, n) rad/s and m/s². step: (6,), of the codes."""

    stamp: np.ndarray
    readings: np.ndarray
    step: np.ndarray


class Logged(Effect):
    """An effect on the rows. form: its name in a case. before_codes: acts before rounding."""

    form: ClassVar[str]
    before_codes: ClassVar[bool] = False
    sized: ClassVar[tuple[str, ...]] = ()

    def logged(self, rows: Rows) -> Rows:
        """The rows as they are written."""
        raise NotImplementedError

    def rng(self) -> np.random.Generator:
        """Random numbers of the log itself."""
        return generator(self.setting.case.seed, f"log {self.name}")


def some_triad(rng: np.random.Generator) -> str:
    return str(rng.choice(list(TRIADS)))


# What firmware does to the numbers: ranges, axes, dead zones, codes, limits.


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


# What the logger does to rows and stamps: held, doubled, interpolated, scattered, in batches.


class HeldRows(Logged):
    """The sensor is slower than the log: its last sample is written again until the next comes."""

    name, form = "repeated_samples", "repeated_samples_held"
    units: ClassVar = {"rate": "1"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"rate": float(rng.choice([0.25, 0.5, rng.uniform(0.55, 0.95)]))}

    def logged(self, rows: Rows) -> Rows:
        new = np.floor(np.arange(len(rows.stamp)) * self.parameters["rate"])
        first = np.searchsorted(new, new)
        return replace(rows, readings=rows.readings[:, first])


class DoubledRows(Logged):
    """A share of the rows is missed, and the row before is written in its place."""

    name, form = "repeated_samples", "repeated_samples_doubled"
    units: ClassVar = {"share": "1"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"share": float(rng.uniform(0.03, 0.3))}

    def logged(self, rows: Rows) -> Rows:
        count = len(rows.stamp)
        fresh = self.rng().uniform(size=count) >= self.parameters["share"]
        fresh[0] = True
        source = np.maximum.accumulate(np.where(fresh, np.arange(count), 0))
        return replace(rows, readings=rows.readings[:, source])


class InterpolatedRows(Logged):
    """The log was brought to a higher rate by straight lines between every n-th reading."""

    name, form = "repeated_samples", "repeated_samples_interpolated"
    units: ClassVar = {"every": "1"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"every": int(rng.integers(2, 6))}

    def logged(self, rows: Rows) -> Rows:
        kept = slice(None, None, self.parameters["every"])
        lines = [np.interp(rows.stamp, rows.stamp[kept], each[kept]) for each in rows.readings]
        return replace(rows, readings=np.stack(lines))


class ScatteredStamps(Logged):
    """The stamp is written when the host gets to it: it scatters about the true instant."""

    name = form = "timestamp_jitter"
    units: ClassVar = {"sigma": "s"}
    sized: ClassVar[tuple[str, ...]] = ("sigma",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"sigma": 2e-3}

    def logged(self, rows: Rows) -> Rows:
        return replace(rows, stamp=scattered(self.rng(), rows.stamp, self.parameters["sigma"]))


class BatchedStamps(Logged):
    """Rows arrive in batches and get stamps that close up to the batch's arrival."""

    name, form = "timestamp_jitter", "timestamp_jitter_batched"
    units: ClassVar = {"batch": "1", "squeeze": "1"}

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"batch": int(rng.integers(3, 9)), "squeeze": float(rng.uniform(0.5, 0.95))}

    def logged(self, rows: Rows) -> Rows:
        batch, count = self.parameters["batch"], len(rows.stamp)
        last = np.minimum(np.arange(count) // batch * batch + batch - 1, count - 1)
        away = rows.stamp[last] - rows.stamp
        mean = float(np.mean(away)) * self.parameters["squeeze"]  # the mean instant stays
        return replace(rows, stamp=rows.stamp + self.parameters["squeeze"] * away - mean)


# Memory in other forms than the plain plant's: play, Preisach, decay; steps of single axes.


class HysteresisPlay(Effect):
    """A gyro's bias is the strain of a spring that slips: the play operator of the angle turned.

    Strain grows with the angle up to `width`, keeps there, and turns back with the motion
    (Prandtl's elastic-slip element); bias = amplitude · strain / width.
    """

    name, form = "hysteresis", "hysteresis_play"
    units: ClassVar = {"amplitude": "rad/s", "width": "rad"}
    sized = ("amplitude",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"amplitude": (1.2e-3 * unit_vector(rng)).tolist(),
                "width": float(rng.uniform(0.03, 0.5))}  # fmt: skip

    def sense(self, world: World) -> np.ndarray:
        strains = [_slipping(rate * world.motion.step / self.parameters["width"], rate)
                   for rate in world.motion.rates]  # fmt: skip
        return on_gyros(self.column("amplitude") * np.stack(strains))


def _slipping(turned: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """The strain between −1 and 1 that follows increments of its input and slips at ± 1."""
    strain = np.empty(len(turned))
    last = 0.0
    for low, high, _ in in_one_direction(rate):
        strain[low:high] = np.clip(last + np.cumsum(turned[low:high]), -1.0, 1.0)
        last = float(strain[high - 1])
    return strain


class HysteresisPreisach(Effect):
    """A gyro's bias is the mean of relays of its own rate (Preisach): what it went through stays.

    Relay k goes up above centre_k + half_k and down below centre_k − half_k, in shares of the
    run's top rate; all of them start down on the negative, up on the positive side of nothing.
    """

    name, form = "hysteresis", "hysteresis_preisach"
    units: ClassVar = {"amplitude": "rad/s", "centre": "1", "half": "1", "top_rate": "rad/s"}
    sized = ("amplitude",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "amplitude": (1.2e-3 * unit_vector(rng)).tolist(),
            "centre": rng.normal(0.0, 0.12, 16).tolist(),
            "half": rng.uniform(0.02, 0.5, 16).tolist(),
            "top_rate": setting.top_rate,
        }

    def sense(self, world: World) -> np.ndarray:
        shares = world.motion.rates / self.parameters["top_rate"]
        relays = zip(self.value("centre"), self.value("half"), strict=True)
        state = np.mean([_relay(shares, low - half, low + half) for low, half in relays], axis=0)
        return on_gyros(self.column("amplitude") * state)


def _relay(inputs: np.ndarray, down: float, up: float) -> np.ndarray:
    """±1 (3, n): +1 since an input last rose above `up`, −1 since it fell below `down`."""
    number = np.arange(inputs.shape[1])
    raised = np.maximum.accumulate(np.where(inputs >= up, number, -1), axis=1)
    fell = np.maximum.accumulate(np.where(inputs <= down, number, -1), axis=1)
    return np.sign(raised - fell).astype(float)


class HysteresisDecay(Effect):
    """A gyro's bias goes to ± amplitude with the way it turns and fades while it rests."""

    name, form = "hysteresis", "hysteresis_decay"
    units: ClassVar = {"amplitude": "rad/s", "angle": "rad", "tau": "s"}
    sized = ("amplitude",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"amplitude": (1.2e-3 * unit_vector(rng)).tolist(), "angle": 0.1,
                "tau": float(rng.uniform(8.0, 40.0))}  # fmt: skip

    def sense(self, world: World) -> np.ndarray:
        return on_gyros(self.column("amplitude") * np.stack([
            self._fading(rate, world.motion.step) for rate in world.motion.rates
        ]))  # fmt: skip

    def _fading(self, rate: np.ndarray, step: float) -> np.ndarray:
        state = np.empty(len(rate))
        last = 0.0
        for low, high, sign in in_one_direction(rate):
            pace = np.full(high - low, step / self.parameters["tau"])
            if sign:
                pace = np.abs(rate[low:high]) * step / self.parameters["angle"]
            state[low:high] = sign + (last - sign) * np.exp(-np.cumsum(pace))
            last = float(state[high - 1])
        return state


class _Step(Effect):
    """One or two channels jump at a time."""

    name = "bias_step"
    units: ClassVar = {"gyro": "rad/s", "accel": "m/s^2", "time": "s"}
    sized = ("gyro", "accel")

    @classmethod
    def stepping(cls, rng: np.random.Generator, time: float) -> Parameters:
        """Parameters with one channel, or one of each triad."""
        gyro, accel = np.zeros(3), np.zeros(3)
        which = int(rng.integers(3))
        if which != 1:
            gyro[rng.integers(3)] = 3e-3 * rng.choice([-1.0, 1.0])
        if which != 0:
            accel[rng.integers(3)] = 3e-2 * rng.choice([-1.0, 1.0])
        return {"gyro": gyro.tolist(), "accel": accel.tolist(), "time": time}

    def sense(self, world: World) -> np.ndarray:
        after = (world.t >= self.parameters["time"]).astype(float)
        return both(self.column("gyro"), self.column("accel"), after)


class BiasStepOfAxes(_Step):
    """One gyro, one accelerometer or one of each steps, at any time."""

    form = "bias_step_single"

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return cls.stepping(rng, float(rng.uniform(0.2, 0.8) * setting.plan.duration))


class BiasStepInMove(_Step):
    """The same, in the middle of a move that lies between a fifth and four fifths of the run."""

    form = "bias_step_moving"

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        middles = [
            (begin + end) / 2.0
            for segment, (begin, end) in zip(
                setting.plan.segments, pairwise(setting.plan.bounds), strict=True
            )
            if segment.goto is not None or segment.turn is not None or segment.name == "held"
        ]
        inner = [t for t in middles if 0.2 < t / setting.plan.duration < 0.8]
        return cls.stepping(rng, float(rng.choice(inner)))


# Sensors in other forms than the plain plant's: rectification, non-linearity, thermal lag.


class RectificationBySpeed(VibrationRectification):
    """Vibration power follows the speed: so does the rectified bias."""

    form = "vibration_rectification_speed"
    EXPONENT: ClassVar = 0.5  # of the vibration's rms

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return super().draw(rng, setting) | {"exponent": cls.EXPONENT, "share": 0.01}


class RectificationBySquare(RectificationBySpeed):
    """Vibration power follows the square of the speed."""

    form = "vibration_rectification_square"
    EXPONENT: ClassVar = 1.0


class GyroQuadraticOdd(Effect):
    """The scale factor grows with the magnitude of the rate: reads c · ω·|ω| / ω_top."""

    name, form = "gyro_scale_nonlinearity", "gyro_scale_nonlinearity_odd_square"
    units: ClassVar = {"coefficient": "1", "top_rate": "rad/s"}
    sized = ("coefficient",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"coefficient": (1e-3 * signs(rng)).tolist(), "top_rate": setting.top_rate}

    def sense(self, world: World) -> np.ndarray:
        rate = world.sensed_rates()
        bent = rate * np.abs(rate) / self.parameters["top_rate"]
        return on_gyros(self.column("coefficient") * bent)


class GyroSoftLimit(GyroQuadraticOdd):
    """The output bends off softly: reads ω_top·(tanh(k·x)/k − x) more, x = ω/ω_top, k² = 3c."""

    form = "gyro_scale_nonlinearity_soft"

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        drawn = super().draw(rng, setting)
        return drawn | {"coefficient": np.abs(drawn["coefficient"]).tolist()}

    def sense(self, world: World) -> np.ndarray:
        top = self.parameters["top_rate"]
        share, k = world.sensed_rates() / top, np.sqrt(3.0 * self.column("coefficient")) + 1e-9
        return on_gyros(top * (np.tanh(k * share) / k - share))


class AccelOddSquare(Effect):
    """The scale factor differs with the magnitude: reads c · f·|f| / g."""

    name, form = "accel_nonlinearity", "accel_nonlinearity_odd_square"
    units: ClassVar = {"coefficient": "1"}
    sized = ("coefficient",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"coefficient": (2e-3 * signs(rng)).tolist()}

    def sense(self, world: World) -> np.ndarray:
        force = world.sensed_force()
        return on_accelerometers(self.column("coefficient") * force * np.abs(force) / STANDARD_G)


class AccelSines(AccelOddSquare):
    """An integral non-linearity of the converter: reads c·g · sin(2π f / g)."""

    form = "accel_nonlinearity_sine"

    def sense(self, world: World) -> np.ndarray:
        wave = np.sin(2.0 * np.pi * world.sensed_force() / STANDARD_G)
        return on_accelerometers(self.column("coefficient") * STANDARD_G * wave)


class LateTemperature(Following):
    """Biases follow a temperature that lags behind the thermometer's by `tau`."""

    name, form = "temperature_bias", "temperature_bias_late"
    units: ClassVar = {"gyro": "(rad/s)/K", "accel": "(m/s^2)/K", "tau": "s"}
    sized = ("gyro", "accel")
    typical: ClassVar = {"gyro": 4e-4, "accel": 5e-3}

    @classmethod
    def beside(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"tau": float(rng.uniform(20.0, 120.0))}

    def course(self, world: World) -> np.ndarray:
        warmer = world.weather.temperature - REFERENCE
        late = lagged(warmer - warmer[0], world.motion.step / self.parameters["tau"])
        return np.asarray(warmer[0] + late)


# Strong effects outside the catalogue: what rigs, cables and ageing electronics do.


class RigMode(Effect):
    """The shaft between encoder and unit is not stiff: a second-order transfer of the angle.

    J·θ̈ + d·(θ̇ − motoṙ) + k·(θ − motor) = 0: H = (1 + 2ζjr) / (1 + 2ζjr − r²), r = f/f₀. Strength
    softens the rig: f₀ falls with its root.
    """

    name = form = "x_rig_mode"
    units: ClassVar = {"frequency": "Hz", "damping": "1"}
    sized = ()

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {
            "frequency": float(rng.uniform(7.0, 16.0)),
            "damping": float(rng.uniform(0.02, 0.1)),
        }

    @classmethod
    def at(cls, typical: Parameters, strength: float) -> Parameters:
        softer = typical["frequency"] / float(np.sqrt(max(strength, 1e-6)))
        return typical | {"frequency": max(softer, 2.0)}

    def shaft(self, motor: np.ndarray) -> np.ndarray:
        length = next_fast_len(2 * motor.shape[1], real=True)
        ratio = rfftfreq(length, 1.0 / fine_rate(self.setting.case)) / self.parameters["frequency"]
        lossy = 1.0 + 2j * self.parameters["damping"] * ratio
        transfer = lossy / (lossy - ratio**2)
        moved = motor.copy()
        line = np.linspace(motor[0, 0], motor[0, -1], motor.shape[1])  # ends alike: no wrap-around
        swung = irfft(rfft(motor[0] - line, length) * transfer, length)[: motor.shape[1]]
        moved[0] = line + swung
        return moved


class Backlash(Effect):
    """A gear between encoder and unit has play: the unit follows when the flank is reached."""

    name = form = "x_backlash"
    units: ClassVar = {"half": "rad"}
    sized = ("half",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"half": 2e-3}

    def shaft(self, motor: np.ndarray) -> np.ndarray:
        moved, last, half = motor.copy(), float(motor[0, 0]), self.parameters["half"]
        for low, high, sign in in_one_direction(np.diff(motor[0], prepend=motor[0, 0]) * 1e3):
            reach = motor[0, low:high] - sign * half
            if sign > 0.0:
                moved[0, low:high] = np.maximum(last, reach)
            elif sign < 0.0:
                moved[0, low:high] = np.minimum(last, reach)
            else:
                moved[0, low:high] = last
            last = float(moved[0, high - 1])
        return moved


class StickSlip(Effect):
    """Friction that comes and goes: in random stretches the unit sticks, then jumps after."""

    name = form = "x_stick_slip"
    units: ClassVar = {"jump": "rad", "share": "1"}
    sized = ("jump",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"jump": 5e-3, "share": float(rng.uniform(0.2, 0.5))}

    def shaft(self, motor: np.ndarray) -> np.ndarray:
        rng = generator(self.setting.case.seed, "stick slip")
        moved, jump, place = motor.copy(), self.parameters["jump"], motor[0]
        tooth = np.floor(place / jump)
        # a smooth stair: sticks for most of a tooth and catches up at its end
        stair = jump * (tooth + (place / jump - tooth) ** 4)
        count = motor.shape[1]
        times = np.sort(rng.uniform(0.0, count, 2 * max(int(self.setting.plan.duration / 8.0), 2)))
        rough = np.interp(np.arange(count), times, rng.uniform(size=len(times)))
        weight = np.clip((self.parameters["share"] - rough) / 0.05, 0.0, 1.0)
        moved[0] = place + weight * (stair - place)
        return moved


class GainDrift(Effect):
    """The scale factors wander in minutes, whatever the temperature: a path of its own for each
    channel, made of three slow waves."""

    name = form = "x_gain_drift"
    units: ClassVar = {"gain": "1"}
    sized = ("gain",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"gain": (2e-3 * rng.uniform(0.3, 1.5, 6)).tolist()}

    def sense(self, world: World) -> np.ndarray:
        rng = generator(self.setting.case.seed, "gain drift")
        paths = np.zeros((6, len(world.t)))
        for _ in range(3):
            period, phase = rng.uniform(25.0, 160.0, 6), rng.uniform(0.0, 2.0 * np.pi, 6)
            paths += np.sin(2.0 * np.pi * world.t / period[:, None] + phase[:, None])
        sensed = np.concatenate([world.sensed_rates(), world.sensed_force()])
        return self.value("gain")[:, None] * paths * sensed


class LooseBoard(Effect):
    """The board sits loose: it tips over by a small angle when gravity pulls it the other way."""

    name = form = "x_loose_board"
    units: ClassVar = {"vector": "rad", "along": "1"}
    sized = ("vector",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        return {"vector": (3e-3 * unit_vector(rng)).tolist(), "along": unit_vector(rng).tolist()}

    def sense(self, world: World) -> np.ndarray:
        side = np.tanh(world.motion.force.T @ self.value("along") / 1.0)
        tip = self.column("vector") * side
        turned = [-np.cross(tip, each, axis=0) for each in (world.motion.rates, world.motion.force)]
        return np.concatenate(turned)


class RubberMount(Effect):
    """The unit sits on rubber: a mode that each change of the specific force excites.

    Accelerometers read H(f)·force, H a resonance on rubber: 1/(1 + 2jζr − r²).
    """

    name = form = "x_rubber_mount"
    units: ClassVar = {"frequency": "Hz", "damping": "1", "share": "1"}
    sized = ("share",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        frequency, damping = float(rng.uniform(6.0, 14.0)), float(rng.uniform(0.03, 0.15))
        return {"frequency": frequency, "damping": damping, "share": 0.1}

    def sense(self, world: World) -> np.ndarray:
        force = world.motion.force
        length = next_fast_len(2 * force.shape[1], real=True)
        ratio = rfftfreq(length, world.motion.step) / self.parameters["frequency"]
        excess = 1.0 / (1.0 + 2j * self.parameters["damping"] * ratio - ratio**2) - 1.0
        mirrored = np.pad(force, [(0, 0), (0, length - force.shape[1])], mode="symmetric")
        swung = irfft(rfft(mirrored) * excess, length)[:, : force.shape[1]]
        return np.concatenate([np.zeros_like(force), self.parameters["share"] * swung])


class DriveLeak(Effect):
    """One gyro hears another's drive: it reads share · |ω| · sin(8 ω/ω_top) of that rate."""

    name = form = "x_drive_leak"
    units: ClassVar = {"share": "1", "heard": "1", "hears": "1", "top_rate": "rad/s"}
    sized = ("share",)

    @classmethod
    def draw(cls, rng: np.random.Generator, setting: Setting) -> Parameters:
        source, hears = rng.choice(3, 2, replace=False)
        return {"share": 5e-3, "heard": int(source), "hears": int(hears),
                "top_rate": setting.top_rate}  # fmt: skip

    def sense(self, world: World) -> np.ndarray:
        source = world.sensed_rates()[self.parameters["heard"]]
        read = np.zeros((6, len(source)))
        top = self.parameters["top_rate"]
        read[self.parameters["hears"]] = self.parameters["share"] * np.abs(source) * np.sin(
            8.0 * source / top
        )  # fmt: skip
        return read


# Every effect that a rough recording may hide, by the name that a case gives it.
#
# Most names are the catalogue's; another form of an effect has its own name here, and the
# catalogue's in `name`.

FORMS: dict[str, type[Effect]] = {
    vars(item)["form"]: item
    for item in [*globals().values()]
    if isinstance(item, type) and item.__module__ == __name__ and "form" in vars(item)
}
KNOWN: dict[str, type[Effect]] = EFFECTS | FORMS


def rough_effects(setting: RoughSetting) -> tuple[Effect, ...]:
    """The effects of a case, those on the log in the order in which they act.

    Raises ValueError for a name that is not known, one that stands twice, or an effect that the
    run cannot have.
    """
    effects = effects_of(setting.case, setting, KNOWN)
    order = {form: place for place, form in enumerate(FORMS)}
    return tuple(sorted(effects, key=lambda e: order[e.form] if isinstance(e, Logged) else -1))
