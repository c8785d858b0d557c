"""The rate points about an axis, as both specifications use them: a line, 7 to 11 points."""

from collections.abc import Iterator, Sequence

import numpy as np

from schemas.text import Remark
from tasks.specifications.error_sources import EquipmentErrors
from tasks.specifications.estimate import MeansFit, fit_means
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import message, remark

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
