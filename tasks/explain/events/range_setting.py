"""Wrong range, unit or counts per unit of a whole triad: all its readings are off by one factor.

The standard's scale factors absorb it, so that no residual shows it. But the scale factors of a
working unit lie near one: all of a triad near another number, and that one of the few that
settings make, is a setting.
"""

from dataclasses import dataclass

import numpy as np

from schemas.discrepancy import FoundParameter
from tasks.explain.channels import TRIADS
from tasks.explain.events.event import TRIAD_NAMES, Event
from tasks.explain.events.triad_matrix import TriadMatrix
from tasks.words import message

STANDARD_GRAVITY = 9.80665  # m/s²
WORKING = 0.05  # standard deviation of a working unit's scale factors about one
NEAR = 0.08  # of a usual factor: as near as working units are
OWN = 0.01  # of the factor: what scale factors of the unit's own may have in common
ALIKE = 0.03  # of the factor: how much the axes may differ
MIN_LOG_ODDS = 12.0  # twice the log of the odds that a claim asks for
POWERS_OF_TWO = tuple(2.0**n for n in range(-5, 6) if n)
# By how much each usual mistake multiplies what is read, by triad: gyros, accelerometers.
BOTH = {
    "power-of-two": POWERS_OF_TWO,
    "thousand": (1e-3, 1e3),
}
USUAL = (
    BOTH | {"degrees": (180.0 / np.pi,), "radians": (np.pi / 180.0,)},
    BOTH | {"gravities": (1.0 / STANDARD_GRAVITY,), "metric": (STANDARD_GRAVITY,)},
)


@dataclass(frozen=True)
class RangeSetting(Event):
    """triad: 0 gyros, 1 accelerometers. factor: that all its readings are multiplied by."""

    triad: int
    factor: float

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return self._times(predicted, self.factor)

    def undone(self, readings: np.ndarray) -> np.ndarray:
        """Readings (n, 6) as a right setting gives them."""
        return self._times(readings, 1.0 / self.factor)

    def _times(self, readings: np.ndarray, factor: float) -> np.ndarray:
        changed = readings.copy()
        changed[:, list(TRIADS[self.triad])] *= factor
        return changed


def find_range_setting(matrix: TriadMatrix, triad: int) -> RangeSetting | None:
    """The factor of a triad, where the scale factors are those of no working unit without it."""
    sizes = np.linalg.svd(matrix.reads, compute_uv=False)
    if not sizes.min() > 0.0:
        return None
    common = float(np.exp(np.log(sizes).mean()))
    spread = float(np.abs(np.log(sizes / common)).max())
    factor, cause = _usual(common, triad)
    if spread > ALIKE or abs(np.log(factor)) < NEAR:
        return None
    if cause == "counts" and len(sizes) < 2:  # of one axis it may be the unit's own
        return None
    log_odds = float(np.sum(_surprise(sizes) - _surprise(sizes / factor)))
    if log_odds < MIN_LOG_ODDS:
        return None
    u = factor * max(abs(common / factor - 1.0), OWN if cause == "counts" else 0.1 * OWN)
    return RangeSetting(
        "range_setting", TRIADS[triad],
        (FoundParameter(name="factor", value=factor, unit="1", u=float(u)),),
        float(np.exp(-0.5 * min(log_odds, 1000.0))),
        message(
            "events-range", sensors=TRIAD_NAMES[triad], factor=f"{factor:.5g}",
            cause=message(f"events-range-{cause}"),
        ), triad, factor,
        indistinguishable=("table_scale",) if triad == 0 and len(sizes) == 1 else (),
    )  # fmt: skip


def _usual(common: float, triad: int) -> tuple[float, str]:
    """The nearest usual factor, and its cause; otherwise the factor itself."""
    factors = [(factor, cause) for cause, some in USUAL[triad].items() for factor in some]
    nearest = min([*factors, (1.0, "counts")], key=lambda one: abs(np.log(common / one[0])))
    return nearest if abs(np.log(common / nearest[0])) < NEAR else (common, "counts")


def _surprise(scale_factors: np.ndarray) -> np.ndarray:
    """Chi-squared of scale factors as those of a working unit, by their logarithm."""
    return np.asarray((np.log(scale_factors) / WORKING) ** 2)
