"""How visible an effect is: its signal beside the noise, after the standard's model took its part.

z² = Σ over channels of the squared norm of what the best fit of the standard's columns leaves,
weighed by the inverse of the true noise spectrum. z is the limit of any detector that knows the
effect's form: its statistic has mean z and deviation 1.
"""

from typing import NamedTuple

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from tests.proof.plant.case import Case
from tests.proof.plant.grades import ACCEL, GYRO, Noise
from tests.proof.plant.noise_free_case import NoiseFree, without_noise
from tests.proof.plant.simulate import Simulated

CLOSE = 0.02  # relative, of z asked for
UNSEEN = 1e-3  # z below which there is nothing to see
STEPS = 10  # steps at most
LARGEST = 100.0  # strength that still makes sense
REACH = 30.0  # how much the strength may change in one step


class Visibility(NamedTuple):
    """z, and concealment: the share of the effect's power that the standard's columns absorb."""

    z: float
    concealment: float


def visibility(simulated: Simulated, effect: str) -> Visibility:
    """The visibility of one effect of a simulated case, beside its other effects."""
    return _Judge(simulated.case, effect).of(simulated.truth - simulated.nominal)


def visibility_of(case: Case, effect: str) -> Visibility:
    """The same from the case alone, without making the noise."""
    return _Judge(case, effect).of(_excess(without_noise(case)))


def visibility_beside(case: Case, added: np.ndarray) -> Visibility:
    """The visibility of readings (n, 6) that are added to those of a case."""
    judge = _Judge(case, "")
    return judge.of(judge.rest + added)


def at_visibility(case: Case, effect: str, z: float) -> Case:
    """The case with the strength of one effect set so that its visibility is z, within 2 %.

    Effects that come in whole numbers or start at a threshold get as near as they can. The Earth
    turns as it does: earth_rotation stays as it is. Raises ValueError for an effect that the
    standard's model absorbs whole in this procedure, or so much of it that it would have to be
    absurdly large.
    """
    if effect == "earth_rotation":
        return case
    judge = _Judge(case, effect)
    strength = next(call.strength for call in case.effects if call.name == effect) or 1.0
    tried: list[tuple[float, float]] = []
    while len(tried) < STEPS:
        reached = judge.of(_excess(without_noise(case.with_strength(effect, strength)))).z
        if not tried and reached < UNSEEN:
            raise ValueError(f"{effect} cannot be seen in this procedure: the standard absorbs it")
        stuck = bool(tried) and tried[-1][1] == reached > z  # nothing smaller is to be had
        tried.append((strength, max(reached, UNSEEN)))
        if stuck or abs(reached / z - 1.0) < CLOSE:
            break
        strength = _next_strength(tried, z)
        if strength > LARGEST:
            raise ValueError(f"{effect} would need {strength:.0f} times its typical size for z {z}")
    best = min(tried, key=lambda pair: abs(np.log(pair[1] / z)))
    return case.with_strength(effect, best[0])


def _next_strength(tried: list[tuple[float, float]], z: float) -> float:
    """In proportion at first, then a secant step in logarithms, kept inside what brackets z."""
    strength, reached = tried[-1]
    slope = 1.0
    if len(tried) > 1:
        earlier, before = tried[-2]
        slope = float(np.clip(np.log(reached / before) / np.log(strength / earlier), 0.3, 4.0))
    wanted = strength * float(np.clip((z / reached) ** (1.0 / slope), 1.0 / REACH, REACH))
    below = max((one for one, observation in tried if observation < z), default=0.0)
    above = min((one for one, observation in tried if observation > z), default=np.inf)
    inside = below < wanted < above
    return wanted if inside or not below < above < np.inf else float(np.sqrt(below * above))


def _excess(noise_free: NoiseFree) -> np.ndarray:
    return (noise_free.truth - noise_free.nominal).T


class _Judge:
    """The rest of the case, without noise, and the standard's columns with their whitening."""

    def __init__(self, case: Case, effect: str) -> None:
        rest = without_noise(case.without(effect))
        self.rest = _excess(rest)
        rates, force = rest.reported[:3].T, rest.reported[3:].T
        one = np.ones((len(rates), 1))
        self.whitenings = [
            _Whitening(noise, len(rates), case.rate_hz)
            for noise in (GYRO[case.grade], ACCEL[case.grade])
        ]
        gyro = np.hstack([rates, one, force])
        self.columns = [gyro] * 3
        for axis in range(3):
            self.columns.append(np.hstack([force, one, np.delete(rates, axis, axis=1) ** 2]))

    def of(self, excess: np.ndarray) -> Visibility:
        """The visibility of what the case (n, 6) has beyond its rest; lost rows count nothing."""
        signal = np.zeros_like(self.rest)
        rows = min(len(excess), len(signal))
        signal[:rows] = excess[:rows] - self.rest[:rows]
        observation = total = left = 0.0
        for channel, series in enumerate(signal.T):
            if not series.any():
                continue
            whiten = self.whitenings[channel // 3]
            columns = _varying(self.columns[channel])
            white, known = whiten(columns.T), whiten(series)
            found, *_ = np.linalg.lstsq(white.T, known, rcond=1e-10)
            observation += float(((known - found @ white) ** 2).sum())
            total += float(series @ series)
            left += float(((series - columns @ found) ** 2).sum())
        return Visibility(
            float(np.sqrt(observation)), max(0.0, 1.0 - left / total) if total else 0.0
        )


def _varying(columns: np.ndarray) -> np.ndarray:
    """The columns at one size, without those that are nowhere (axes that never turn)."""
    size = np.sqrt((columns**2).mean(axis=0))
    return np.asarray(columns[:, size > 1e-12] / size[size > 1e-12])


class _Whitening:
    """Divides courses (…, n) by the root of the noise spectrum; ends are mirrored, not wrapped."""

    def __init__(self, noise: Noise, count: int, rate: float) -> None:
        self.count = count
        self.length = next_fast_len(2 * count, real=True)
        frequency = rfftfreq(self.length, 1.0 / rate)
        frequency[0] = frequency[1] / 2.0
        self.gain = 1.0 / np.sqrt(noise.density(frequency) * rate / 2.0)

    def __call__(self, series: np.ndarray) -> np.ndarray:
        ends = [(0, 0)] * (series.ndim - 1) + [(0, self.length - self.count)]
        mirrored = np.pad(series, ends, mode="symmetric")
        return np.asarray(irfft(rfft(mirrored) * self.gain, self.length)[..., : self.count])
