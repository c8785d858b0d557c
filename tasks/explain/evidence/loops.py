"""Whether the loops of a memory all run the same way round.

Any loop is a sum of plays (Prandtl and Ishlinskii), whose weights are of one sign: each takes
energy. Weights of both signs are a curvature or a derivative of the drive, not a memory of it.
"""

from collections.abc import Sequence

import numpy as np

from tasks.explain.explanation import Refusal
from tasks.model.term import Parameter

MEMORY = "hysteresis"
COVERAGE = 2.0  # standard uncertainties in U


def loops_both_ways(
    effect: str, parameters: Sequence[Parameter], values: np.ndarray, u: np.ndarray
) -> Refusal | None:
    """A memory whose widths have weights of both signs, each larger than its U, in one channel.

    values, u: (k,) of its parameters, weight by weight of each axis.
    """
    if effect != MEMORY:
        return None
    clear = np.where(np.abs(values) > COVERAGE * u, np.sign(values), 0.0)
    signs: dict[tuple[str, str], set[float]] = {}
    for parameter, sign in zip(parameters, clear.tolist(), strict=True):
        channel = parameter.unit, parameter.name.rsplit("_", 1)[-1]
        signs.setdefault(channel, set()).add(sign)
    both = any({1.0, -1.0} <= found for found in signs.values())
    return Refusal("both_ways", effect) if both else None
