"""Faults of logger and firmware that last from the first row to the last: wrong settings and codes.

Both are undone before anything else is looked for. Of settings, axes, range and unit of a triad:
what it reads per unit of each input is the coarsest fact of a unit. A matrix fitted to means over
short windows shows it before anything else is known. A delay, a motion of its own or a fault of the
codes would bend that matrix, too; so that it must leave next to nothing of what is read.

A working unit reads each axis along itself, to within a few degrees: a matrix that does so only
after some axes are exchanged or inverted tells which. And its scale factors lie near one. The
standard's scale factors absorb a wrong range, so that no residual shows it; but all of a triad near
another number, and that one of the few that settings make, is a setting.
"""

from dataclasses import dataclass, replace

import numpy as np

from schemas.discrepancy import FoundParameter
from schemas.recording import AXES
from tasks.explain.channels import CHANNELS, TRIADS
from tasks.explain.events.code_fault import CodeFault
from tasks.explain.events.event import TRIAD_NAMES, Event
from tasks.explain.odds import CERTAIN
from tasks.motion.whole import STANDARD_GRAVITY, Motion
from tasks.readings.axes import TriadMatrix, fitting, triad_matrix
from tasks.readings.wrong_units import REMOVED
from tasks.words import message

STILL = np.radians(0.5)  # rad/s: what turns slower rests
TIED = 0.01  # of what is read along the axes: inputs along the axis of a turn do not show it
WORKING = 0.05  # standard deviation of a working unit's scale factors about one
NEAR = 0.08  # of a usual factor: as near as working units are
OWN = 0.01  # of the factor: what scale factors of the unit's own may have in common
ALIKE = 0.03  # of the factor: how much the axes may differ
# Twice the logarithm by which a factor that is found costs more than one that is usual: it may lie
# anywhere from a tenth to ten, and three axes of working units tell it to 3 %.
OF_ANY_FACTOR = 2.0 * float(np.log(np.log(100.0) / (0.03 * np.sqrt(2.0 * np.pi))))
RANGE_SETTING = "range_setting"
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
class AxisMapping(Event):
    """triad: 0 gyros, 1 accelerometers. matrix: (3, 3) that readings are multiplied by."""

    triad: int
    matrix: np.ndarray

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return self._by(predicted, self.matrix)

    def undone(self, readings: np.ndarray) -> np.ndarray:
        """Readings (n, 6) with each axis in its place."""
        return self._by(readings, self.matrix.T)

    def _by(self, readings: np.ndarray, matrix: np.ndarray) -> np.ndarray:
        changed = readings.copy()
        own = list(TRIADS[self.triad])
        changed[:, own] = readings[:, own] @ matrix.T
        return changed


def axis_mapping(triad: int, matrix: np.ndarray, with_mount: bool) -> AxisMapping:
    """The event of a signed permutation; with_mount: a wrongly stated mount would look the same."""
    rows = [row for row in range(3) if matrix[row, row] != 1.0]
    texts = []
    for row in rows:
        source = int(np.abs(matrix[row]).argmax())
        channel = message(f"channel-{CHANNELS[TRIADS[triad][row]]}")
        sign = "+" if matrix[row, source] > 0 else "−"
        texts.append(message("events-axis-reads", channel=channel, sign=sign, axis=AXES[source]))
    parameters = tuple(
        FoundParameter(name=f"{AXES[row]}{AXES[k]}", value=float(matrix[row, k]), unit="1", u=0.0)
        for row in rows for k in range(3) if matrix[row, k]
    )  # fmt: skip
    return AxisMapping(
        "axis_mapping", tuple(TRIADS[triad][row] for row in rows), parameters, 1e-12,
        message("events-axis-mapping", sensors=TRIAD_NAMES[triad], axes=tuple(texts)),
        triad, matrix, indistinguishable=("reference_frame",) if with_mount else (),
    )  # fmt: skip


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
    if cause == "counts":
        log_odds -= OF_ANY_FACTOR
    if log_odds < CERTAIN:
        return None
    u = factor * max(abs(common / factor - 1.0), OWN if cause == "counts" else 0.1 * OWN)
    return RangeSetting(
        RANGE_SETTING, TRIADS[triad],
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


Setting = RangeSetting | AxisMapping


@dataclass(frozen=True, eq=False)
class GravityRemoved(Event):
    """force: (n, 3) m/s² of gravity's reaction, which was taken off the accelerometers' rows."""

    force: np.ndarray

    def applied(self, t: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        return self._with(predicted, -1.0)

    def undone(self, readings: np.ndarray) -> np.ndarray:
        """Readings (n, 6) with gravity, NaN of accelerometers where the attitude is not known."""
        return self._with(readings, 1.0)

    def _with(self, readings: np.ndarray, sign: float) -> np.ndarray:
        changed = readings.copy()
        changed[:, list(TRIADS[1])] += sign * self.force
        return changed


Fault = Setting | CodeFault | GravityRemoved


def find_gravity_removed(readings: np.ndarray, motion: Motion) -> GravityRemoved | None:
    """Accelerometers that read next to nothing at rest, where the attitude is known."""
    force = motion.force
    still = np.linalg.norm(np.nan_to_num(motion.rate, nan=np.inf), axis=1) < STILL
    still &= np.isfinite(force).all(axis=1)
    read = (
        np.median(np.linalg.norm(readings[still][:, list(TRIADS[1])], axis=1))
        if still.any()
        else 0.0
    )
    if not 0.0 < read < REMOVED * motion.gravity:
        return None
    return GravityRemoved(
        "gravity_removed", TRIADS[1],
        (FoundParameter(name="at_rest", value=float(read), unit="m/s2", u=0.0),), 1e-12,
        message("plausibility-gravity-removed", read=f"{read:.2g}"), force,
    )  # fmt: skip


def find_settings(readings: np.ndarray, motion: Motion, tracked: bool) -> tuple[Setting, ...]:
    """Wrong settings of readings (n, 6) rad/s, m/s², in the order in which they act.

    tracked: the motion is that of a tracked body, which may be turned against the unit in any way,
    so that what turns both triads alike is the reference's.
    """
    matrices = [triad_matrix(readings, motion, triad) for triad in range(len(TRIADS))]
    known = {triad: found for triad, found in enumerate(matrices) if found is not None}
    ranges = [find_range_setting(found, triad) for triad, found in known.items()]
    return (*_mappings(known, tracked), *(found for found in ranges if found is not None))


def _mappings(matrices: dict[int, TriadMatrix], tracked: bool) -> list[AxisMapping]:
    choices = {triad: fitting(found) for triad, found in matrices.items()}
    wrong = [t for t, good in choices.items() if good and not np.array_equal(good[0], np.eye(3))]
    if not wrong:
        return []
    common = [
        matrix
        for matrix in choices[wrong[0]]
        if np.linalg.det(matrix) > 0 and all(_reads_as(one, matrix) for one in matrices.values())
    ]
    # What a turned mount, or tracked body, would do to all that is known.
    if common:
        return [] if tracked else [axis_mapping(triad, common[0], True) for triad in wrong]
    return [axis_mapping(triad, choices[triad][0], False) for triad in wrong]


def _reads_as(found: TriadMatrix, turned: np.ndarray) -> bool:
    """Whether a triad reads as one that is turned, at least as well as one that is not: a single
    attitude leaves both open where the turn is about its vertical.
    """
    along = [float(np.sum((one @ found.directions) * found.reads)) for one in (turned, np.eye(3))]
    good = fitting(replace(found, reads=turned.T @ found.reads))
    is_along = any(np.array_equal(one, np.eye(3)) for one in good)
    return is_along and along[0] > (1.0 - TIED) * along[1]
