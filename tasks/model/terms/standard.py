"""Models (1) and (2) of JJF 2003-2022, 5.1 and 5.2, as terms.

Gyro: ω′ = K·ω + B + G·f; accelerometer: a′ = K·f + B + P·ω². First index: the axis that reads.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from schemas.recording import AXES
from tasks.model.term import Column, Inputs, Parameter, Term
from tasks.motion.whole import Motion

DEG = float(np.degrees(1.0))
MATRIX = tuple((i, j) for i in range(3) for j in range(3))
OFF_DIAGONAL = tuple((i, j) for i, j in MATRIX if i != j)
GYRO_FIRST, ACCEL_FIRST = 0, 3  # channels of the x axes


@dataclass(frozen=True)
class LinearTerm(Term):
    """Each parameter multiplies one regressor in one channel.

    regressors: (n, k) from the motion and what the sensors feel.
    reads: for each parameter the channel and the regressor.
    """

    regressors: Callable[[Motion, Inputs], np.ndarray] = field(kw_only=True)
    reads: tuple[tuple[int, int], ...] = field(kw_only=True)

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        basis = self.regressors(motion, inputs).T
        return tuple({channel: basis[k]} for channel, k in self.reads)


def _matrix(
    symbol: str, unit: str, factor: float, largest: float, ideal: float
) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(
            f"{AXES[i]}{AXES[j]}", f"{symbol}{AXES[i]}{AXES[j]}", unit, factor,
            ((i == j) * ideal - largest, (i == j) * ideal + largest), (i == j) * ideal,
        )
        for i, j in MATRIX
    )  # fmt: skip


def _bias(symbol: str, unit: str, factor: float, largest: float) -> tuple[Parameter, ...]:
    return tuple(Parameter(a, f"{symbol}{a}", unit, factor, (-largest, largest)) for a in AXES)


def _rates(motion: Motion, inputs: Inputs) -> np.ndarray:
    return inputs.rate


def _forces(motion: Motion, inputs: Inputs) -> np.ndarray:
    return inputs.force


def _in_local_g(motion: Motion, inputs: Inputs) -> np.ndarray:
    return inputs.force / motion.gravity


def _squares(motion: Motion, inputs: Inputs) -> np.ndarray:
    return inputs.rate**2


def _ones(motion: Motion, inputs: Inputs) -> np.ndarray:
    return np.ones((len(motion.t), 1))


def _on(first: int, which: tuple[tuple[int, int], ...]) -> tuple[tuple[int, int], ...]:
    return tuple((first + i, j) for i, j in which)


ONE_EACH = tuple((i, 0) for i in range(3))

GYRO_MATRIX = LinearTerm(
    "gyro_matrix", "standard", "sensor", "ω′ᵢ = Σⱼ K_gij·ωⱼ", "JJF 2003-2022, 5.1 eq. (1)",
    _matrix("K_g", "1", 1.0, 0.1, 1.0), regressors=_rates, reads=_on(GYRO_FIRST, MATRIX),
)  # fmt: skip
GYRO_BIAS = LinearTerm(
    "gyro_bias", "standard", "sensor", "ω′ᵢ = B_gi", "JJF 2003-2022, 5.1 eq. (1)",
    _bias("B_g", "deg/s", DEG, 0.1), regressors=_ones, reads=_on(GYRO_FIRST, ONE_EACH),
)  # fmt: skip
GYRO_G_SENSITIVITY = LinearTerm(
    "gyro_g_sensitivity", "standard", "sensor", "ω′ᵢ = Σⱼ g_ij·fⱼ/g", "JJF 2003-2022, 5.1 eq. (1)",
    _matrix("g_", "(deg/s)/g", DEG, 0.01, 0.0),
    regressors=_in_local_g, reads=_on(GYRO_FIRST, MATRIX),
)  # fmt: skip
ACCEL_MATRIX = LinearTerm(
    "accel_matrix", "standard", "sensor", "a′ᵢ = Σⱼ K_aij·fⱼ", "JJF 2003-2022, 5.2 eq. (2)",
    _matrix("K_a", "1", 1.0, 0.1, 1.0), regressors=_forces, reads=_on(ACCEL_FIRST, MATRIX),
)  # fmt: skip
ACCEL_BIAS = LinearTerm(
    "accel_bias", "standard", "sensor", "a′ᵢ = B_ai", "JJF 2003-2022, 5.2 eq. (2)",
    _bias("B_a", "m/s2", 1.0, 1.0), regressors=_ones, reads=_on(ACCEL_FIRST, ONE_EACH),
)  # fmt: skip
ACCEL_RATE_SENSITIVITY = LinearTerm(
    "accel_rate_sensitivity", "standard", "sensor", "a′ᵢ = Σⱼ p_ij·ωⱼ², j ≠ i",
    "JJF 2003-2022, 5.2 eq. (2)",
    tuple(
        Parameter(AXES[i] + AXES[j], f"p_{AXES[i]}{AXES[j]}", "m", 1.0, (-0.1, 0.1))
        for i, j in OFF_DIAGONAL
    ),
    regressors=_squares, reads=_on(ACCEL_FIRST, OFF_DIAGONAL),
)  # fmt: skip

GYRO_TERMS = (GYRO_MATRIX, GYRO_BIAS, GYRO_G_SENSITIVITY)
ACCEL_TERMS = (ACCEL_MATRIX, ACCEL_BIAS, ACCEL_RATE_SENSITIVITY)
STANDARD_TERMS: tuple[LinearTerm, ...] = (*GYRO_TERMS, *ACCEL_TERMS)


def regressors(
    motion: Motion, channel: int, terms: tuple[LinearTerm, ...] = STANDARD_TERMS
) -> np.ndarray:
    """Regressors (n, k) of one channel, 0 to 5: a column for each parameter that it reads.

    In the order of the terms and their parameters: a gyro reads ω, 1 and f, an accelerometer f, 1
    and the ω² of the two other axes. ω is in rad/s and f in units of local gravity, so that the
    columns are of order one. NaN where the motion is not known.
    """
    motion = replace(motion, gravity=1.0)
    inputs = Inputs(motion.rate, motion.force)
    return np.column_stack([
        column[channel]
        for term in terms
        if any(reader == channel for reader, _ in term.reads)
        for column in term.columns(motion, inputs)
        if channel in column
    ])  # fmt: skip
