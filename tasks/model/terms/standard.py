"""Models (1) and (2) of JJF 2003-2022, 5.1 and 5.2, as terms.

Gyro: ω′ = K·ω + B + G·f; accelerometer: a′ = K·f + B + P·ω². First index: the axis that reads.
"""

from dataclasses import replace

import numpy as np

from schemas.recording import AXES
from tasks.model.term import (
    ACCEL_FIRST,
    GYRO_FIRST,
    MATRIX,
    OFF_DIAGONAL,
    Inputs,
    Parameter,
    SensorTerm,
    crossed,
    own,
)
from tasks.motion.whole import Motion


def _matrix(symbol: str, unit: str, si: str, largest: float, ideal: float) -> tuple[Parameter, ...]:
    return tuple(
        Parameter(
            f"{AXES[i]}{AXES[j]}", f"{symbol}{AXES[i]}{AXES[j]}", unit, si,
            ((i == j) * ideal - largest, (i == j) * ideal + largest), (i == j) * ideal,
        )
        for i, j in MATRIX
    )  # fmt: skip


def _bias(symbol: str, unit: str, si: str, largest: float) -> tuple[Parameter, ...]:
    return tuple(Parameter(a, f"{symbol}{a}", unit, si, (-largest, largest)) for a in AXES)


GYRO_MATRIX = SensorTerm(
    "gyro_matrix", "standard", "sensor", "ω′ᵢ = Σⱼ K_gij·ωⱼ", "JJF 2003-2022, 5.1 eq. (1)",
    _matrix("K_g", "1", "1", 0.1, 1.0),
    reads=lambda motion, inputs, at: crossed(GYRO_FIRST, inputs.rate),
)  # fmt: skip
GYRO_BIAS = SensorTerm(
    "gyro_bias", "standard", "sensor", "ω′ᵢ = B_gi", "JJF 2003-2022, 5.1 eq. (1)",
    _bias("B_g", "deg/s", "rad/s", 0.1),
    reads=lambda motion, inputs, at: own(GYRO_FIRST, np.ones((len(motion.t), 3))),
)  # fmt: skip
GYRO_G_SENSITIVITY = SensorTerm(
    "gyro_g_sensitivity", "standard", "sensor", "ω′ᵢ = Σⱼ g_ij·fⱼ/g", "JJF 2003-2022, 5.1 eq. (1)",
    _matrix("g_", "(deg/s)/g", "(rad/s)/g", 0.01, 0.0),
    reads=lambda motion, inputs, at: crossed(GYRO_FIRST, inputs.force / motion.gravity),
)  # fmt: skip
ACCEL_MATRIX = SensorTerm(
    "accel_matrix", "standard", "sensor", "a′ᵢ = Σⱼ K_aij·fⱼ", "JJF 2003-2022, 5.2 eq. (2)",
    _matrix("K_a", "1", "1", 0.1, 1.0),
    reads=lambda motion, inputs, at: crossed(ACCEL_FIRST, inputs.force),
)  # fmt: skip
ACCEL_BIAS = SensorTerm(
    "accel_bias", "standard", "sensor", "a′ᵢ = B_ai", "JJF 2003-2022, 5.2 eq. (2)",
    _bias("B_a", "m/s2", "m/s2", 1.0),
    reads=lambda motion, inputs, at: own(ACCEL_FIRST, np.ones((len(motion.t), 3))),
)  # fmt: skip
ACCEL_RATE_SENSITIVITY = SensorTerm(
    "accel_rate_sensitivity", "standard", "sensor", "a′ᵢ = Σⱼ p_ij·ωⱼ², j ≠ i",
    "JJF 2003-2022, 5.2 eq. (2)",
    tuple(
        Parameter(AXES[i] + AXES[j], f"p_{AXES[i]}{AXES[j]}", "m", "m", (-0.1, 0.1))
        for i, j in OFF_DIAGONAL
    ),
    reads=lambda motion, inputs, at: crossed(ACCEL_FIRST, inputs.rate**2, OFF_DIAGONAL),
)  # fmt: skip

GYRO_TERMS = (GYRO_MATRIX, GYRO_BIAS, GYRO_G_SENSITIVITY)
ACCEL_TERMS = (ACCEL_MATRIX, ACCEL_BIAS, ACCEL_RATE_SENSITIVITY)
STANDARD_TERMS: tuple[SensorTerm, ...] = (*GYRO_TERMS, *ACCEL_TERMS)


def regressors(
    motion: Motion, channel: int, terms: tuple[SensorTerm, ...] = STANDARD_TERMS
) -> np.ndarray:
    """Regressors (n, k) of one channel, 0 to 5: a column for each parameter that it reads.

    In the order of the terms and their parameters: a gyro reads ω, 1 and f, an accelerometer f, 1
    and the ω² of the two other axes. ω is in rad/s and f in units of local gravity, so that the
    columns are of order one. NaN where the motion is not known.
    """
    moved = motion.translation
    in_g = None if moved is None else moved / motion.gravity
    motion = replace(motion, gravity=1.0, translation=in_g)
    inputs = Inputs.of(motion)
    return np.column_stack([
        column[channel]
        for term in terms
        for column in term.columns(motion, inputs)
        if channel in column
    ])  # fmt: skip
