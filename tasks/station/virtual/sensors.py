"""The unit under test: from rate and specific force to counts on its own clock."""

import numpy as np
from scipy import signal

from tasks.station.virtual.config import STEP_S, TriadTruth, UnitTruth

FLICKER_TIMES_S = (1.0, 10.0, 100.0, 1000.0)


class LowPass:
    """Second order, three channels, at the plant's rate."""

    def __init__(self, bandwidth_hz: float) -> None:
        self._sections = signal.butter(2, bandwidth_hz, fs=1.0 / STEP_S)
        self._state: np.ndarray | None = None

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """Filters (3, n), going on from the last call; it begins at rest on the first value."""
        if self._state is None:
            self._state = signal.lfilter_zi(*self._sections) * values[:, :1]
        filtered, self._state = signal.lfilter(*self._sections, values, axis=1, zi=self._state)
        return filtered


class SensorNoise:
    """White noise and relaxations from 1 s to 1000 s, which together fall like 1/f: 6 channels."""

    def __init__(self, unit: UnitTruth) -> None:
        self._rng = np.random.default_rng(np.random.SeedSequence((unit.seed, 1)))
        triads = (unit.gyro, unit.accel)
        self._white = np.repeat([triad.white * np.sqrt(unit.rate_hz) for triad in triads], 3)
        self._flicker = np.repeat([triad.flicker for triad in triads], 3)
        self._keep = np.exp(-1.0 / (unit.rate_hz * np.array(FLICKER_TIMES_S)))
        self._state = self._rng.standard_normal((len(FLICKER_TIMES_S), 6))

    def draw(self, samples: int) -> np.ndarray:
        """The next samples, (samples, 6); the same however they are cut into calls."""
        drawn = self._rng.standard_normal((samples, 1 + len(FLICKER_TIMES_S), 6))
        total = drawn[:, 0] * self._white
        for row, keep in enumerate(self._keep):
            kicks = drawn[:, row + 1] * np.sqrt(1.0 - keep**2)
            start = keep * self._state[row][None]
            slow, last = signal.lfilter([1.0], [1.0, -keep], kicks, axis=0, zi=start)
            self._state[row] = last[0] / keep
            total += slow * self._flicker
        return total


class Thermometer:
    """The unit's inside warms toward the air plus its own heat."""

    def __init__(self, unit: UnitTruth, air_degc: float, on_s: float) -> None:
        self._unit = unit
        self._last = (on_s, air_degc)

    def read(self, t: np.ndarray, air_degc: float) -> np.ndarray:
        """Temperature (n,) degC at station times t (s) behind the last ones, the air held."""
        since, started = self._last
        goal = air_degc + self._unit.self_heating_k
        degc = goal + (started - goal) * np.exp(-(t - since) / self._unit.heating_time_s)
        self._last = (float(t[-1]), float(degc[-1]))
        return degc

    def cool(self, t: float, air_degc: float) -> None:
        """It was off, and took on the temperature of the air, until a station time (s)."""
        since, started = self._last
        left = np.exp(-(t - since) / self._unit.heating_time_s)
        self._last = (t, air_degc + (started - air_degc) * float(left))


def to_counts(triad: TriadTruth, values: np.ndarray) -> np.ndarray:
    """Values (n, 3) in the triad's quantity as its counts, clipped at full scale."""
    clipped = np.clip(values, -triad.full_scale, triad.full_scale)
    return np.rint(clipped / triad.lsb).astype(np.int32)


class UnitUnderTest:
    """Takes the plant's motion, gives samples at the unit's own times.

    step: of the plant at which it was mounted.
    """

    def __init__(self, unit: UnitTruth, air_degc: float, step: int = 0) -> None:
        self._unit = unit
        self._gyro = LowPass(unit.gyro.bandwidth_hz)
        self._accel = LowPass(unit.accel.bandwidth_hz)
        self._noise = SensorNoise(unit)
        self._thermometer = Thermometer(unit, air_degc, step * STEP_S)
        self._rows = np.array(unit.accel.scale)
        self._places = np.array(unit.places_m)
        self._last = np.empty((6, 0))
        self._step = step  # of the first value that comes next
        self._number = 0  # of the sample that comes next
        self._on_s = step * STEP_S + unit.clock_offset_s  # station time of its power-on
        self._is_on = True

    def switch_off(self) -> None:
        """No more samples."""
        self._is_on = False

    def switch_on(self, air_degc: float) -> None:
        """Its clock, its counter and what it accumulates begin anew; it has cooled meanwhile."""
        self._is_on, self._number, self._on_s = True, 0, self._step * STEP_S
        self._thermometer.cool(self._on_s, air_degc)

    def sense(
        self, rate: np.ndarray, angular: np.ndarray, gravity: np.ndarray, air_degc: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The next plant steps (3, n) each to samples.

        Returns their numbers (m,), unit time in µs (m,), counts (m, 6) and degC (m,).
        """
        felt, steps = self._moving(rate, angular, gravity), rate.shape[1]
        numbers, t = self._due(self._step + steps - 1)
        values = self._at(t, felt)
        self._step += steps
        return self._read(numbers, t, values, air_degc)

    def rest(
        self, rate: np.ndarray, gravity: np.ndarray, steps: int, air_degc: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """As many plant steps to samples, rate and gravity (3, 1) the same in all of them."""
        numbers, t = self._due(self._step + steps - 1)
        values = self._resting(t, steps, rate, gravity)
        self._step += steps
        return self._read(numbers, t, values, air_degc)

    def _read(
        self, numbers: np.ndarray, t: np.ndarray, values: np.ndarray, air_degc: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        if not len(numbers):
            return numbers, numbers.astype(np.uint64), np.empty((0, 6), np.int32), t
        self._number = int(numbers[-1]) + 1
        degc = self._thermometer.read(t, air_degc)
        counts = self._counts(values, self._noise.draw(len(numbers)) + self._bias(degc))
        stamps = np.rint(numbers / self._unit.rate_hz * 1e6).astype(np.uint64)
        return numbers, stamps, counts, degc

    def _moving(self, rate: np.ndarray, angular: np.ndarray, gravity: np.ndarray) -> np.ndarray:
        """What the sensors feel at each step, filtered, (6, n)."""
        return np.vstack([self._gyro(self._turn(rate, gravity)),
                          self._accel(self._force(rate, angular, gravity))])  # fmt: skip

    def _resting(
        self, t: np.ndarray, steps: int, rate: np.ndarray, gravity: np.ndarray
    ) -> np.ndarray:
        """What they feel at the sample times (m,) at rest, (m, 6): filters have come to rest."""
        turn, force = self._turn(rate, gravity), self._force(rate, 0.0 * rate, gravity)
        self._last = np.vstack([turn, force])
        return np.tile(self._last, len(t)).T

    def _counts(self, values: np.ndarray, errors: np.ndarray) -> np.ndarray:
        """Counts (m, 6) of what is felt, with the errors of noise and bias."""
        gyro = to_counts(self._unit.gyro, values[:, :3] + errors[:, :3])
        return np.hstack([gyro, to_counts(self._unit.accel, values[:, 3:] + errors[:, 3:])])

    def _turn(self, rate: np.ndarray, gravity: np.ndarray) -> np.ndarray:
        unit = self._unit
        return np.array(unit.gyro.scale) @ rate + np.array(unit.g_sensitivity) @ gravity

    def _force(self, rate: np.ndarray, angular: np.ndarray, gravity: np.ndarray) -> np.ndarray:
        """Each accelerometer's row k at its own place r: k·(f + α×r + ω×(ω×r))."""
        k, r = self._rows, self._places
        inward = (k @ rate) * (r @ rate) - np.sum(k * r, axis=1)[:, None] * np.sum(rate**2, axis=0)
        return k @ gravity + np.cross(r, k) @ angular + inward

    def _bias(self, degc: np.ndarray) -> np.ndarray:
        gyro, accel = self._unit.gyro, self._unit.accel
        slope = np.hstack([gyro.bias_per_kelvin, accel.bias_per_kelvin])
        away = (degc - self._unit.settled_degc)[:, None]
        return np.hstack([gyro.bias, accel.bias]) + away * slope

    def _due(self, last_step: int) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the samples taken up to a step, and their station times (s)."""
        rate = self._unit.rate_hz * (1.0 + self._unit.clock_skew)
        last = int(np.floor((last_step * STEP_S - self._on_s) * rate + 1e-6)) if self._is_on else -1
        numbers = np.arange(self._number, last + 1)
        return numbers, self._on_s + numbers / rate

    def _at(self, t: np.ndarray, felt: np.ndarray) -> np.ndarray:
        """The filtered values at the sample times, (m, 6), straight between the steps."""
        held = np.hstack([self._last, felt])
        place = t / STEP_S - (self._step - self._last.shape[1])
        left = np.clip(np.floor(place + 1e-6).astype(int), 0, held.shape[1] - 1)
        right = np.minimum(left + 1, held.shape[1] - 1)
        part = np.clip(place - left, 0.0, 1.0)
        self._last = felt[:, -1:]
        return (held[:, left] * (1.0 - part) + held[:, right] * part).T


class Ahrs(UnitUnderTest):
    """A unit that gives angles about its own axes since power-on: it adds up what its gyros feel.

    It has no gyro low-pass.
    """

    def __init__(self, unit: UnitTruth, air_degc: float, step: int = 0) -> None:
        super().__init__(unit, air_degc, step)
        self._begin_angles()

    def switch_on(self, air_degc: float) -> None:
        """The angles begin anew."""
        super().switch_on(air_degc)
        self._begin_angles()

    def _begin_angles(self) -> None:
        self._angle = np.zeros((3, 1))  # half a step after the last one
        self._drift = np.zeros(3)  # of noise and bias, up to the last sample

    def _moving(self, rate: np.ndarray, angular: np.ndarray, gravity: np.ndarray) -> np.ndarray:
        turned = self._turn(rate, gravity) * STEP_S
        ends = self._angle + np.cumsum(turned, axis=1)
        self._angle = ends[:, -1:]
        # A rate is that of the middle of its step, which half of what it adds comes before.
        return np.vstack([ends - 0.5 * turned, self._accel(self._force(rate, angular, gravity))])

    def _resting(
        self, t: np.ndarray, steps: int, rate: np.ndarray, gravity: np.ndarray
    ) -> np.ndarray:
        turn = self._turn(rate, gravity)
        now = self._angle - 0.5 * turn * STEP_S
        angles = now + turn * (t - (self._step - 1) * STEP_S)
        self._angle = self._angle + turn * (steps * STEP_S)
        force = self._force(rate, 0.0 * rate, gravity)
        self._last = np.vstack([self._angle - 0.5 * turn * STEP_S, force])
        return np.vstack([angles, np.tile(force, len(t))]).T

    def _counts(self, values: np.ndarray, errors: np.ndarray) -> np.ndarray:
        """errors: of the rates, which add up to errors of the angle."""
        assert self._unit.angle_lsb is not None
        drift = self._drift + np.cumsum(errors[:, :3], axis=0) / self._unit.rate_hz
        self._drift = drift[-1]
        angle = np.rint((values[:, :3] + drift) / self._unit.angle_lsb).astype(np.int64)
        return np.hstack([angle, to_counts(self._unit.accel, values[:, 3:] + errors[:, 3:])])
