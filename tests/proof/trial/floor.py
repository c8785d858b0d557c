"""What noise alone makes of the standard's parameters: nobody who has to fit them is nearer."""

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from schemas.recording import ACCEL, GYRO
from tests.proof.plant.grades import Noise, channel_noise
from tests.proof.plant.simulate import Simulated


def floor_of(clean: Simulated) -> float:
    """Σ over channels of |error|²/σ² of models (1) and (2), fitted to a case without effects.

    The fit weighs by the inverse of the true noise spectrum; σ is the grade's white noise. It is
    about the number of parameters, and with flicker noise many times that.
    """
    case = clean.case
    noise = clean.recording.imu.stack(GYRO + ACCEL) - clean.truth
    rates, force = clean.reported[:, :3], clean.reported[:, 3:]
    one = np.ones((len(rates), 1))
    total = 0.0
    for channel, model in enumerate(channel_noise(case.grade)):
        beside = np.delete(rates, channel - 3, axis=1) ** 2 if channel >= 3 else rates
        columns = np.hstack([force, one, beside])
        columns = columns[:, (columns**2).mean(axis=0) > 0.0]
        white = _whitened(np.column_stack([columns, noise[:, channel]]), model, case.rate_hz)
        found, *_ = np.linalg.lstsq(white[:, :-1], white[:, -1], rcond=1e-10)
        error = columns @ found / (model.white * np.sqrt(case.rate_hz / 2.0))
        total += float(error @ error)
    return total


def _whitened(courses: np.ndarray, model: Noise, rate: float) -> np.ndarray:
    """Courses (n, k) divided by the root of the noise spectrum; ends are mirrored."""
    count = len(courses)
    length = next_fast_len(2 * count, real=True)
    frequency = rfftfreq(length, 1.0 / rate)
    frequency[0] = frequency[1] / 2.0
    gain = np.sqrt(model.density(frequency))[:, None]
    mirrored = np.pad(courses, ((0, length - count), (0, 0)), mode="symmetric")
    return np.asarray(irfft(rfft(mirrored, axis=0) / gain, length, axis=0)[:count])
