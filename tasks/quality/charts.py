"""Control charts of individual values and moving ranges, with the Nelson rules.

D. C. Montgomery, Introduction to Statistical Quality Control, 6.4; NIST/SEMATECH e-Handbook of
Statistical Methods, 6.3.2.2; L. S. Nelson, The Shewhart control chart: tests for special causes,
J. Quality Technology 16 (1984) 237.
"""

from dataclasses import dataclass

import numpy as np

from tasks.quality.capability import FEWEST, sigma_within

D4 = 3.267  # upper limit of ranges of two, in their mean
RULES = 8


@dataclass(frozen=True)
class Chart:
    """A chart of (n,) values in the order of time.

    centre, sigma: of the values. ranges: (n,) from the value before; NaN for the first.
    mean_range, range_limit: centre and upper limit of the ranges. broken: (8, n) bool, at which
    value each rule of Nelson was broken: the last one of those that break it.
    """

    centre: float
    sigma: float
    ranges: np.ndarray
    mean_range: float
    range_limit: float
    broken: np.ndarray

    @property
    def limits(self) -> tuple[float, float]:
        """Three sigma on either side of the centre."""
        return self.centre - 3.0 * self.sigma, self.centre + 3.0 * self.sigma


def individuals(values: np.ndarray) -> Chart | None:
    """The chart of values (n,), their own mean and moving ranges as the process; None of one."""
    if len(values) < FEWEST:
        return None
    ranges = np.concatenate([[np.nan], np.abs(np.diff(values))])
    centre, sigma, mean = float(values.mean()), sigma_within(values), float(np.nanmean(ranges))
    standard = (values - centre) / sigma if sigma > 0.0 else np.zeros(len(values))
    return Chart(centre, sigma, ranges, mean, D4 * mean, nelson(standard))


def nelson(z: np.ndarray) -> np.ndarray:
    """(8, n) bool: at which value each rule is broken. z: (n,) distance from the centre in sigma.

    1: beyond 3 sigma. 2: nine in a row on one side. 3: six in a row rising, or falling. 4: fourteen
    in a row up and down in turn. 5: two of three beyond 2 sigma on one side. 6: four of five beyond
    1 sigma on one side. 7: fifteen in a row within 1 sigma. 8: eight in a row beyond 1 sigma.
    """
    step = np.sign(np.diff(z, prepend=np.nan))
    turns = np.concatenate([[False], step[1:] * step[:-1] < 0])
    return np.stack([
        np.abs(z) > 3.0,
        _one_side(z, 0.0, 9, 9),
        _row(step > 0, 5) | _row(step < 0, 5),
        _row(turns, 12),
        _one_side(z, 2.0, 2, 3),
        _one_side(z, 1.0, 4, 5),
        _row(np.abs(z) < 1.0, 15),
        _row(np.abs(z) > 1.0, 8),
    ])  # fmt: skip


def _one_side(z: np.ndarray, beyond: float, of: int, out_of: int) -> np.ndarray:
    """Where `of` of the last `out_of` are beyond on one side, the value itself among them."""
    found = np.zeros(len(z), bool)
    for side in (z, -z):
        is_out = side > beyond
        found |= is_out & (_counted(is_out, out_of) >= of)
    return found


def _row(holds: np.ndarray, length: int) -> np.ndarray:
    """Where it holds for the last `length` in a row."""
    return _counted(holds, length) >= length


def _counted(holds: np.ndarray, length: int) -> np.ndarray:
    """(n,) for how many of the last `length` it holds; fewer are there at the beginning."""
    total = np.concatenate([np.zeros(length, int), np.cumsum(holds)])
    return np.asarray(total[length:] - total[:-length])
