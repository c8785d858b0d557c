"""Random numbers that depend on the case's seed and on what they are for, and on nothing else."""

from zlib import crc32

import numpy as np


def generator(seed: int, purpose: str) -> np.random.Generator:
    """A generator of its own for each purpose: a new effect does not shift the noise."""
    return np.random.default_rng([seed, crc32(purpose.encode())])
