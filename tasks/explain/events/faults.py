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

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from schemas.discrepancy import FoundParameter
from schemas.recording import AXES
from tasks.explain.channels import CHANNELS, TRIADS
from tasks.explain.events.code_fault import CodeFault
from tasks.explain.events.event import TRIAD_NAMES, Event
from tasks.motion.samples import in_blocks
from tasks.motion.whole import Motion
from tasks.words import message

WINDOW = 0.25  # s of a mean
EXCITED = (0.05, 0.5)  # rad/s, m/s²: standard deviation of an input that shows how it is read
SLOW = 0.5  # rad/s below which an accelerometer off the axis feels next to nothing of a turn
MIN_WINDOWS = 20
MAX_LEFT = 0.25  # of what is read: root of the share of its power that the matrix leaves
ALIGNED = np.radians(20.0)  # from the axis it should be on: a working unit, roughly fixed
ASTRAY = np.radians(60.0)  # from there: another axis, or the other way round
MATRICES = tuple(
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
)
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
class TriadMatrix:
    """directions: (3, r) orthonormal inputs that vary; reads: (3, r) what is read of each."""

    directions: np.ndarray
    reads: np.ndarray


def triad_matrix(readings: np.ndarray, motion: Motion, triad: int) -> TriadMatrix | None:
    """The matrix of a triad, 0 or 1, from readings (n, 6) rad/s, m/s²; None if it does not fit.

    A single attitude shows the response of the accelerometers to gravity except for their bias.
    """
    means = _means(readings[:, list(TRIADS[triad])], motion, triad)
    if means is None:
        return None
    read, felt = means
    centre, middle = read.mean(axis=0), felt.mean(axis=0)
    sizes, axes = np.linalg.eigh(np.cov((felt - middle).T))
    directions = axes[:, sizes > EXCITED[triad] ** 2]
    if not directions.size:
        if triad == 0:
            return None
        size = float(np.linalg.norm(middle))
        return TriadMatrix(middle[:, None] / size, centre[:, None] / size)
    along = (felt - middle) @ directions
    reads = np.linalg.lstsq(along, read - centre, rcond=None)[0].T
    left = read - centre - along @ reads.T
    if np.sum(left**2) > MAX_LEFT**2 * np.sum((read - centre) ** 2):
        return None
    return TriadMatrix(directions, reads)


def _means(
    readings: np.ndarray, motion: Motion, triad: int
) -> tuple[np.ndarray, np.ndarray] | None:
    """Readings and inputs (m, 3) over whole windows in which both are known."""
    rows = max(1, round(WINDOW / max(motion.interval, 1e-9)))
    inputs = (motion.rate, motion.force)[triad]
    both = np.hstack([readings, inputs])
    if triad == 1:  # while it turns fast, only where nothing else was recorded
        slow = np.linalg.norm(motion.rate, axis=1) < SLOW
        still = np.where(slow[:, None], both, np.nan)
        if np.isfinite(in_blocks(still, rows)).all(axis=(1, 2)).sum() >= MIN_WINDOWS:
            both = still
    blocks = in_blocks(both, rows)
    blocks = blocks[np.isfinite(blocks).all(axis=(1, 2))]
    if len(blocks) < MIN_WINDOWS:
        return None
    means = blocks.mean(axis=1)
    return means[:, :3], means[:, 3:]


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


def fitting(found: TriadMatrix) -> list[np.ndarray]:
    """The signed permutations with which a triad reads along its axes, fewest changes first."""
    if _astray(found, np.eye(3)) < ASTRAY:
        return [np.eye(3)]
    good = [matrix for matrix in MATRICES if _astray(found, matrix) < ALIGNED]
    return sorted(good, key=_changes)


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


def _astray(found: TriadMatrix, matrix: np.ndarray) -> float:
    """The largest angle between the response to an input and that of a permutation."""
    expected = matrix @ found.directions
    size = np.linalg.norm(found.reads, axis=0)
    cosine = np.sum(expected * found.reads, axis=0) / np.where(size > 0, size, 1.0)
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)).max())


def _changes(matrix: np.ndarray) -> tuple[int, int]:
    """How many axes are not read as they should be, and how many of them are inverted."""
    return int(3 - np.sum(np.diag(matrix) == 1.0)), int(np.sum(matrix < 0))


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


Setting = RangeSetting | AxisMapping


Fault = Setting | CodeFault


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
        if np.linalg.det(matrix) > 0
        and all(any(np.array_equal(matrix, one) for one in good) for good in choices.values())
    ]
    # What a turned mount, or tracked body, would do to all that is known.
    if common and len(wrong) == len(matrices):
        return [] if tracked else [axis_mapping(triad, common[0], True) for triad in wrong]
    return [axis_mapping(triad, choices[triad][0], False) for triad in wrong]
