"""The rate points about an axis, as both specifications ask for them: 7 to 11, both ways."""

from collections.abc import Iterator

import numpy as np

from schemas.calibration import Remark
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
            "specifications-number-of-rates",
            axis=axis,
            count=len(distinct),
            rates=", ".join(f"{rate:+g}" for rate in distinct),
            clause=clause,
            fewest=FEWEST_RATES,
            most=MOST_RATES,
        )
        yield remark("number_of_rates", text, blocks_pass=True)
    if distinct[0] >= 0 or distinct[-1] <= 0:
        text = message("specifications-one-direction", axis=axis)
        yield remark("one_direction", text, blocks_pass=True)
