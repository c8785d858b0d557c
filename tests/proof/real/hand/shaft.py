"""The unit on the shaft beside the shaft's encoder: how late it is, and what it damps.

The encoder's angle and the integral of the gyro about the shaft are the same angle, so that no
derivative of the coarse encoder (0.08 deg) is ever needed.
"""

from itertools import pairwise

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.signal import csd, savgol_filter, welch

from schemas.recording import GYRO, Recording
from tests.proof.real.hand.measured import Measured, strongest

RATE = 100.0  # Hz
PER_WINDOW = 3000  # samples: 30 s
COHERENT = 0.98
SLOW, STEPPER = (1.0, 5.0), (12.6, 13.0)  # Hz: strokes, and the resonance of the stepper
EDGE = 2.0  # s left out at either end
PARTS = 6
MOST = 0.4  # s, lag
STROKE = 7.808  # s, to and fro


def even_courses(recording: Recording) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """t, encoder angle rad, gyro about the shaft rad/s, on an even grid of 100 Hz.

    About the shaft is the gyro that turns most.
    """
    imu, table = recording.imu, recording.table
    assert table is not None
    t = np.arange(imu.t[0], imu.t[-1], 1.0 / RATE)
    angle = np.interp(t, table.t, table.columns["shaft_angle"])
    gyros = [np.interp(t, imu.t, imu.columns[name]) for name in GYRO]
    rate = max(gyros, key=lambda each: float(each.std()))
    alike = float(np.corrcoef(np.gradient(angle), rate)[0, 1])
    return t, angle, rate if alike > 0.0 else -rate


def transfer(recording: Recording) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From the shaft's rate to the gyro: frequency Hz, complex gain, coherence 0 to 1."""
    _, angle, rate = even_courses(recording)
    frequency, cross = csd(angle, rate, RATE, nperseg=PER_WINDOW)
    _, own = welch(angle, RATE, nperseg=PER_WINDOW)
    _, other = welch(rate, RATE, nperseg=PER_WINDOW)
    used = slice(2, None)  # 0 Hz has no phase, and its neighbour leaks from it
    coherence = np.abs(cross[used]) ** 2 / (own[used] * other[used])
    gain = cross[used] / own[used] / (2j * np.pi * frequency[used])
    return frequency[used], gain, coherence


def alike(gain: np.ndarray, coherence: np.ndarray) -> np.ndarray:
    """Where both see the same motion: (m,) bool. At 10.2 Hz something else shakes the unit."""
    return (coherence > COHERENT) & (np.abs(np.abs(gain) - 1.0) < 0.25)


def delay_by_phase(recording: Recording) -> Measured:
    """Slope of the phase of the transfer function over frequency, where it is coherent, s."""
    frequency, gain, coherence = transfer(recording)
    good = alike(gain, coherence) & (frequency > SLOW[0]) & (frequency < STEPPER[1])
    # A whole turn of phase is no small delay: the angles tell which turn it is.
    about = delay_by_angle(recording).value
    omega = 2.0 * np.pi * frequency[good]
    delay = about - np.angle(gain[good] * np.exp(1j * omega * about)) / omega
    weight = frequency[good] ** 2 * coherence[good] / (1.0 - coherence[good])
    mean = float((weight * delay).sum() / weight.sum())
    effective = weight.sum() ** 2 / (weight**2).sum()
    spread = float((weight * (delay - mean) ** 2).sum() / weight.sum())
    return Measured(mean, float(np.sqrt(spread / effective)), "s")


def delay_by_angle(recording: Recording) -> Measured:
    """The lag at which the summed gyro follows the encoder's angle best, s; u: parts' scatter."""
    t, angle, rate = even_courses(recording)
    turned = np.concatenate([[0.0], np.cumsum(rate[1:] + rate[:-1]) / (2.0 * RATE)])
    each = [_best_lag(part, t, angle, turned) for part in _parts(t)]
    return Measured(float(np.mean(each)), float(np.std(each, ddof=1) / np.sqrt(len(each))), "s")


def delay_by_gravity(recording: Recording) -> Measured:
    """How late the accelerometers see gravity turn, s.

    accel = a·sin θ + b·cos θ + c, lever arm and lag by terms in θ̈, θ̇² and θ̇: the lag is what
    turns the pattern with the rate. Mean of the two accelerometers across the shaft; u: scatter.
    """
    imu, (t, angle, _) = recording.imu, even_courses(recording)
    speed, bend = (savgol_filter(angle, 21, 3, deriv=n, delta=1.0 / RATE) for n in (1, 2))
    sin, cos = np.sin(angle), np.cos(angle)
    columns = [sin, cos, np.ones_like(sin), speed * cos, -speed * sin, bend, speed**2]
    found = []
    for name in ("accel_x", "accel_z"):
        series = np.interp(t, imu.t, imu.columns[name])
        for part in _parts(t):
            A = np.column_stack(columns)[part]
            a, b, _, c, d, *_ = np.linalg.lstsq(A, series[part], rcond=None)[0]
            found.append(-(c * a + d * b) / (a * a + b * b))
    return Measured(float(np.mean(found)), float(np.std(found) / np.sqrt(len(found))), "s")


def delay_by_pattern(recording: Recording) -> Measured:
    """The lag, s, at which a·sin θ + b·cos θ + c follows the accelerometers best; no lever arm."""
    imu, (t, angle, _) = recording.imu, even_courses(recording)
    observation = [np.interp(t, imu.t, imu.columns[name]) for name in ("accel_x", "accel_z")]

    def left(lag: float, part: np.ndarray) -> float:
        turned = np.interp(t - lag, t, angle)[part]
        A = np.column_stack([np.sin(turned), np.cos(turned), np.ones_like(turned)])
        return sum(float(np.linalg.lstsq(A, y[part], rcond=None)[1][0]) for y in observation)

    each = [
        float(minimize_scalar(left, bounds=(-MOST, MOST), args=(part,), method="bounded").x)
        for part in _parts(t)
    ]
    return Measured(float(np.mean(each)), float(np.std(each, ddof=1) / np.sqrt(len(each))), "s")


def corner(recording: Recording) -> Measured:
    """Corner of a first-order low-pass, Hz, by the gain at the stepper's 12.8 Hz beside slow."""
    frequency, gain, coherence = transfer(recording)
    slow, fast = (
        (coherence > COHERENT) & (frequency > low) & (frequency < high)
        for low, high in (SLOW, STEPPER)
    )
    weight = 1.0 / (1.0 - coherence)
    least = np.average(np.abs(gain[slow]), weights=weight[slow])
    ratio = np.average(np.abs(gain[fast]), weights=weight[fast]) / least
    at = float(np.average(frequency[fast], weights=weight[fast]))
    scatter = float(np.abs(gain[slow]).std() / least / np.sqrt(slow.sum()))
    value = at / np.sqrt(ratio**-2 - 1.0)
    u = value * scatter / (ratio**2 * (ratio**-2 - 1.0))
    return Measured(float(value), float(u), "Hz")


def _parts(t: np.ndarray) -> list[np.ndarray]:
    edges = np.linspace(t[0] + EDGE, t[-1] - EDGE, PARTS + 1)
    return [(t >= a) & (t < b) for a, b in pairwise(edges)]


def _best_lag(part: np.ndarray, t: np.ndarray, angle: np.ndarray, turned: np.ndarray) -> float:
    found = minimize_scalar(
        _scatter,
        bounds=(-MOST, MOST),
        args=(part, t, angle, turned),
        method="bounded",
        options={"xatol": 1e-6},
    )
    return float(found.x)


def _scatter(
    lag: float, part: np.ndarray, t: np.ndarray, angle: np.ndarray, turned: np.ndarray
) -> float:
    observation = np.interp(t + lag, t, turned)[part]
    A = np.column_stack([observation, np.ones_like(observation), t[part]])
    left = angle[part] - A @ np.linalg.lstsq(A, angle[part], rcond=None)[0]
    return float(left.std())


def line_shared(recording: Recording) -> tuple[float, float]:
    """Frequency, Hz, and coherence with the encoder of the strongest line above 8 Hz."""
    t, _, rate = even_courses(recording)
    at = strongest(t, rate, 8.0, 40.0)
    frequency, _, coherence = transfer(recording)
    return at, float(coherence[np.abs(frequency - at).argmin()])


def jump_at(recording: Recording, channel: str, when: float) -> Measured:
    """Mean of a channel over four strokes to and fro after a time, less that before."""
    t, series = recording.imu.t, recording.imu.columns[channel]
    sides = [
        [series[(t >= when + n * STROKE) & (t < when + (n + 1) * STROKE)].mean() for n in strokes]
        for strokes in (range(-4, 0), range(4))
    ]
    u = float(np.linalg.norm([np.std(each, ddof=1) / 2.0 for each in sides]))
    return Measured(float(np.mean(sides[1]) - np.mean(sides[0])), u, "rad/s")


def excursion(recording: Recording, channel: str, start: float, stop: float) -> Measured:
    """Mean of a channel over a stretch less that at the same place of the other strokes.

    u: the scatter of the others.
    """
    t, series = recording.imu.t, recording.imu.columns[channel]
    strokes = range(-int(start // STROKE), int((t[-1] - stop) // STROKE) + 1)
    others = [
        series[(t >= start + n * STROKE) & (t < stop + n * STROKE)].mean() for n in strokes if n
    ]
    own = series[(t >= start) & (t < stop)].mean()
    return Measured(float(own - np.mean(others)), float(np.std(others, ddof=1)), "rad/s")
