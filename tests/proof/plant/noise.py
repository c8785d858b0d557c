"""Noise with a given spectrum."""

import numpy as np
from scipy.fft import irfft, next_fast_len, rfftfreq

from tests.proof.plant.grades import Noise


def noise(rng: np.random.Generator, model: Noise, count: int, rate: float) -> np.ndarray:
    """White and flicker noise (count,) at `rate` samples per second.

    A Gaussian process with exactly the stated density, twice as long as needed so that its end
    does not know its beginning: flicker reaches down to half the inverse of the duration.
    """
    length = next_fast_len(2 * count, real=True)
    frequency = rfftfreq(length, 1.0 / rate)[1:]
    # a one-sided density S gives each pair of bins the mean square |X|² = S · rate · length / 2
    amplitude = np.sqrt(model.density(frequency) * rate * length / 4.0)
    spectrum = np.zeros(len(frequency) + 1, dtype=complex)
    spectrum[1:] = amplitude * (
        rng.standard_normal(len(frequency)) + 1j * rng.standard_normal(len(frequency))
    )
    if length % 2 == 0:
        spectrum[-1] = spectrum[-1].real * np.sqrt(2.0)
    return np.asarray(irfft(spectrum, length)[:count])
