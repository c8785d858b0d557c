"""The lever arm from the rotation axes, and the rate sensitivity without it.

While it turns steadily an accelerometer feels p·ω² and the lever arm's −r·ω² alike; in the ramps
it feels α × r besides. Both together, and the unit's own bias and scale factor, are fitted to the
rests, turns and ramps about the vertical, with the lever arm as a term (`tasks.model`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from schemas.base import Unusable
from schemas.calibration import Information, Item
from schemas.recording import ACCEL, AXES, Recording, Stream
from tasks.calibrate.information.entry import entry, or_why_not, type_b, without_type_b
from tasks.model.fit import Fit, fit
from tasks.model.model import predict
from tasks.model.noise import RowNoise
from tasks.model.term import Term
from tasks.model.terms.geometry import LEVER_ARM
from tasks.model.terms.standard import ACCEL_RATE_SENSITIVITY, ACCEL_TERMS
from tasks.motion.whole import Motion, whole_motion
from tasks.readings.robust import TO_SIGMA
from tasks.segments.summarise import ACCEL_COLUMNS
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import message

CELL = 0.1  # s: ramps are cut into cells of this length
WITHIN = 5  # times within a ramp's cell at which its angular acceleration is looked up
FASTEST = 200.0  # Hz
CORNER = 0.15  # of the angular acceleration, from cell to cell: no smooth ramp bends so
CELLS_AT_RATE = 10  # cells that make one where the rate is steady
RAMPING = 0.02  # rad/s² of angular acceleration: a ramp
LEVEL = np.radians(0.05)  # rad/s across the vertical: more than this is a move, not a turn
MIN_RAMPING = 20  # cells about each axis
PASSES = 6
OUTLYING = 6.0  # robust standard deviations beyond which a cell is no signal of this model
SENSITIVITY = "accel_rate_sensitivity"
TERMS: tuple[Term, ...] = (LEVER_ARM, *ACCEL_TERMS)


@dataclass(frozen=True)
class Cells:
    """Mean readings and motion over short cells of rest or of turning about the vertical.

    readings: (n, 6) with NaN for the gyros, m/s²; seconds: (n,) length of each.
    """

    motion: Motion
    readings: np.ndarray
    seconds: np.ndarray


def lever_arm_information(
    evidence: ClauseEvidence, items: Mapping[str, Item]
) -> dict[str, Information]:
    """Lever arm (m) and, where the specification has the rate sensitivity, its value without it
    (m, sign of eq. (12)), where ramps show them.

    Type B is that of the rate sensitivity by the clause: the same rates about the same axes, in
    which the lever arm enters as the sensitivity does.
    Nothing without encoders and gravity, or without ramps about all three axes with the
    accelerometers recorded.
    """
    noise_known = np.isfinite(evidence.noise.white[:, ACCEL_COLUMNS]).any()
    cells = _cells(_thinned(evidence.recording)) if noise_known else None
    if cells is None:
        return {}
    try:
        fitted = _fit(cells, evidence)
    except Unusable:
        return {}
    r, u = fitted.values[:3], fitted.u[:3]
    p, u_p = -fitted.values[-6:], fitted.u[-6:]
    if not np.isfinite([*r, *p]).all():
        return {}
    excess = max(1.0, float(np.sqrt(fitted.chi2 / fitted.degrees)))
    arm, free = message("information-lever-arm.text"), message("information-without-lever-arm.text")
    elements = [parameter.name for parameter in ACCEL_RATE_SENSITIVITY.parameters]
    equipment = type_b(items.get(SENSITIVITY), elements)
    of_axis = [  # of a coordinate: the largest of what reads along it
        max((b for e, b in zip(elements, equipment, strict=True) if e[0] == axis), default=np.nan)
        for axis in AXES
    ]
    u, u_p = np.hypot(excess * u, of_axis), np.hypot(excess * u_p, equipment)
    found = {"lever_arm": entry("lever-arm", "m", r, u, arm, *or_why_not(u))}
    if SENSITIVITY in items:
        found["accel_rate_sensitivity_without_lever_arm"] = entry(
            "without-lever-arm",
            "m",
            p,
            u_p,
            free,
            *or_why_not(u_p),
            *without_type_b(u_p, elements),
            elements=elements,
            about=SENSITIVITY,
        )
    return found


def _thinned(recording: Recording) -> Recording:
    """The recording with encoders read no more than FASTEST times a second: ramps take longer."""
    table = recording.table
    if table is None or len(table) < 2:
        return recording
    every = int((table.t[-1] - table.t[0]) * FASTEST)
    step = max(1, len(table) // max(1, every))
    if step == 1:
        return recording
    return replace(recording, table=table.at(slice(None, None, step)))


def _cells(recording: Recording) -> Cells | None:
    """The cells of a recording, None where they cannot show a lever arm."""
    manifest, imu = recording.manifest, recording.imu
    known = recording.table is not None and manifest.station.gravity_m_s2 is not None
    if not known or not all(name in imu.columns for name in ACCEL) or len(imu) < 2:
        return None
    count = int((imu.t[-1] - imu.t[0]) / CELL)
    edges = imu.t[0] + CELL * np.arange(count + 1)
    motion = whole_motion(recording, edges[:-1] + 0.5 * CELL)
    across = motion.rate - (motion.rate * motion.up).sum(axis=1)[:, None] * motion.up
    usable = motion.known & (np.linalg.norm(across, axis=1) < LEVEL)
    changing = np.linalg.norm(motion.acceleration, axis=1) > RAMPING
    changing = _widened(changing)  # a cell at a ramp's end has some
    usable &= ~_widened(changing & _at_corner(motion.acceleration))
    about = np.abs(np.nan_to_num(motion.up)).argmax(axis=1)
    if min(np.bincount(about[usable & changing], minlength=3)) < MIN_RAMPING:
        return None
    _average_acceleration(recording, motion, np.flatnonzero(usable & changing))
    starts = _starts(usable, changing)
    sizes = np.diff(np.append(starts, count))
    readings, full = _mean_readings(imu, edges[starts], edges[starts + sizes])
    middle = 0.5 * (edges[starts] + edges[starts + sizes])
    up, north, rate, acceleration = (
        np.add.reduceat(vectors, starts, axis=0) / sizes[:, None]
        for vectors in (motion.up, motion.north, motion.rate, motion.acceleration)
    )
    keep = usable[starts] & full
    whole = Motion(middle, up, north, rate, acceleration, motion.gravity)
    return Cells(whole.taken(keep), readings[keep], CELL * sizes[keep])


def _at_corner(acceleration: np.ndarray) -> np.ndarray:
    """(n,) bool: cells in which the angular acceleration (n, 3) sets in or ends at once.

    There the smoothed acceleration is less than the true one, and the lever arm would be too long.
    """
    around = np.pad(acceleration, ((1, 1), (0, 0)), mode="edge")
    bend = np.linalg.norm(around[2:] - 2 * acceleration + around[:-2], axis=1)
    size = np.linalg.norm(around, axis=1)
    return bend > CORNER * np.maximum(np.maximum(size[2:], size[:-2]), size[1:-1])


def _widened(flags: np.ndarray) -> np.ndarray:
    """True also beside each True."""
    return np.convolve(flags, np.ones(3), "same") > 0


def _average_acceleration(recording: Recording, motion: Motion, cells: np.ndarray) -> None:
    """Puts the mean over each of these cells in the place of the value in its middle."""
    within = CELL * ((np.arange(WITHIN) + 0.5) / WITHIN - 0.5)
    fine = whole_motion(recording, (motion.t[cells, None] + within).ravel())
    motion.acceleration[cells] = fine.acceleration.reshape(-1, WITHIN, 3).mean(axis=1)


def _starts(usable: np.ndarray, changing: np.ndarray) -> np.ndarray:
    """First cell of each merged one: alone in a ramp, else up to CELLS_AT_RATE together."""
    steady = usable & ~changing
    new = np.ones(len(usable), bool)
    new[1:] = ~(steady[1:] & steady[:-1])
    run = np.arange(len(new)) - np.maximum.accumulate(np.where(new, np.arange(len(new)), 0))
    return np.flatnonzero(new | (run % CELLS_AT_RATE == 0))


def _mean_readings(
    imu: Stream, start: np.ndarray, stop: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Mean accelerometer readings (n, 6), NaN for the gyros, and (n,) whether there are rows."""
    first, last = np.searchsorted(imu.t, start), np.searchsorted(imu.t, stop)
    full = last > first
    means = np.full((len(start), 6), np.nan)
    for k, name in enumerate(ACCEL):
        summed = np.concatenate([[0.0], np.cumsum(imu.columns[name])])
        means[full, 3 + k] = (summed[last] - summed[first])[full] / (last - first)[full]
    return means, full


def _fit(cells: Cells, evidence: ClauseEvidence) -> Fit:
    """Lever arm and accelerometer terms; cells far from the fit are left out of the next."""
    white = np.ones((len(cells.seconds), 6))
    per_second = np.nanmedian(evidence.noise.white[:, ACCEL_COLUMNS], axis=0)
    white[:, ACCEL_COLUMNS] = per_second / cells.seconds[:, None]
    near = np.ones(len(white), bool)
    start = None
    for _ in range(PASSES):
        noise = RowNoise(cells.motion.t[near], white[near], evidence.noise.drift)
        fitted = fit(TERMS, cells.motion.taken(near), cells.readings[near], noise, start)
        misses = cells.readings - predict(TERMS, cells.motion, fitted.values)
        size = np.abs(misses / np.sqrt(white))[:, ACCEL_COLUMNS]
        reach = OUTLYING * np.maximum(TO_SIGMA * np.median(size, axis=0), 1.0)
        previous, near = near, ~(size > reach).any(axis=1)
        if (near == previous).all():
            break
        start = fitted.values
    return fitted
