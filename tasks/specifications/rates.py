"""The rate points about an axis, as both specifications use them: a line, 7 to 11 points."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from schemas.recording import AXES, Axis
from schemas.text import Remark
from tasks.specifications.error_sources import EquipmentErrors
from tasks.specifications.estimate import MeansFit, fit_means
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.linear import solve
from tasks.words import message, remark

SQUARE = 1e-6  # rad, a fifth of an arc second: so crooked is no mount that anybody states
FEWEST_RATES, MOST_RATES = 7, 11


def distinct_rates(rates: np.ndarray) -> list[float]:
    """The different rates (deg/s, to a tenth) among (n,) rad/s, rising."""
    return sorted(set(np.round(np.degrees(rates), 1).tolist()))


def rate_remarks(axis: str, rates: np.ndarray, clause: str) -> Iterator[Remark]:
    """Where there are fewer or more rates (rad/s) than the clause asks for, or one direction."""
    distinct = distinct_rates(rates)
    if not FEWEST_RATES <= len(distinct) <= MOST_RATES:
        text = message(
            "specifications-number-of-rates", axis=axis, count=len(distinct),
            rates=", ".join(f"{rate:+g}" for rate in distinct), clause=clause, fewest=FEWEST_RATES,
            most=MOST_RATES,
        )  # fmt: skip
        yield remark("number_of_rates", text, blocks_pass=True)
    if distinct[0] >= 0 or distinct[-1] <= 0:
        text = message("specifications-one-direction", axis=axis)
        yield remark("one_direction", text, blocks_pass=True)


def fit_line(
    evidence: ClauseEvidence,
    channel: int,
    points: Sequence[int],
    errors: EquipmentErrors,
    rests: Sequence[int] = (),
) -> MeansFit:
    """Slope and offset over the rate points, eq. (5) of JJF 2003 and eq. (14) of JJF 1536.

    rests: whose mean is subtracted from the output of each point.
    """
    rates = evidence.rate[list(points)]
    outputs = np.eye(len(evidence.segments))[list(points)]
    outputs[:, list(rests)] = -1.0 / max(1, len(rests))
    design = np.column_stack([rates, np.ones(len(rates))])
    return fit_means(evidence, channel, design, outputs, errors)


def weights_about(
    evidence: ClauseEvidence,
    axis: Axis,
    rate: np.ndarray,
    runs: Mapping[Axis, Sequence[int]],
    readings: Mapping[Axis, np.ndarray],
) -> np.ndarray | None:
    """Weights (n,) of what a gyro reads per rate about an axis of the unit.

    rate: (n, 3) rad/s of each segment in the unit's axes. runs, readings: which segments turned,
    and the weights of what it read per rate in them, by the axis that was laid along the table's.
    Turned about a it reads K·a: a row of K follows from all directions. None: the unit stood too
    crooked for those.
    """
    if axis not in readings:
        return None
    design = np.array([direction(evidence, laid, rate, runs[laid]) for laid in readings])
    solution, place = solve(np.where(np.abs(design) < SQUARE, 0.0, design)), AXES.index(axis)
    if not solution.estimable[place]:
        return None
    return np.asarray(solution.operator[place].round(12) @ np.array([*readings.values()]))


def direction(
    evidence: ClauseEvidence, laid: Axis, rate: np.ndarray, turns: Sequence[int]
) -> np.ndarray:
    """Mean direction (3,) in the unit's axes of turns about the table's, per rate about it.

    Where nobody knows it, that of the axis that was laid along it.
    """
    turned, held = rate[list(turns)], np.abs(evidence.rate[list(turns)])
    size = np.where(np.isfinite(held), held, np.linalg.norm(turned, axis=1))
    signed = np.copysign(size, turned[:, AXES.index(laid)])
    known = np.isfinite(turned).all(axis=1) & (signed != 0.0)
    if not known.any():
        return np.eye(3)[AXES.index(laid)]
    return np.asarray((turned[known] / signed[known, None]).mean(axis=0))
