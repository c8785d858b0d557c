"""Signals recorded beside the readings, interpolated to the unit's rows."""

from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from schemas.recording import Recording, Segment
from tasks.motion.samples import bridged
from tasks.readings.robust import deviation

MEAN_WIDTH = 5.0  # s: a unit's temperature does not change faster
MIN_MEANS = 6
MAX_EXCESS = 1.3  # times what scatters from mean to mean
JUMP = 10.0  # times what a signal usually changes by from sample to sample
MIN_JUMP = 0.3  # of a signal's range
MAX_UNKNOWN = 0.02  # of the rows: a signal that jumps more often is interpolated
MAX_DEGREE = 60  # of the polynomial: cycles of a minute in a run of half an hour


def recorded_signals(
    recording: Recording, t: np.ndarray, segments: tuple[Segment, ...]
) -> dict[str, np.ndarray]:
    """What sensors of unit and room recorded, at the unit's rows, and which fixing it was."""
    recorded = {}
    if "temperature" in recording.imu.columns:
        recorded["temperature"] = recording.imu.columns["temperature"]
    if (room := recording.environment) is not None:
        for name, signal in room.columns.items():
            key = "air_temperature" if name == "temperature" else name
            recorded[key] = np.interp(t, room.t, signal)
    if "temperature" in recorded:
        filled = bridged(recorded["temperature"][:, None])[:, 0]
        recorded["temperature"], recorded["temperature_rate"] = _smoothed(t, filled)
    recorded["fixing"] = _fixings(recording, t, segments)
    recorded["steady_turn"] = np.zeros(len(t))
    for segment in segments:
        if segment.kind == "rate":
            recorded["steady_turn"][recording.imu.rows(segment.t_start, segment.t_end)] = 1.0
    return recorded


def within_jumps(recording: Recording, t: np.ndarray) -> np.ndarray:
    """(n,) bool: rows between two samples of a room's signal between which it jumps.

    The time of the jump is not known to the row, so no law of the signal can be tested on these
    readings: a jump of the unit itself, whose time is fitted, would always fit better.
    """
    unknown = np.zeros(len(t), bool)
    if (room := recording.environment) is None:
        return unknown
    for signal in room.columns.values():
        change = np.abs(np.diff(signal))
        if len(change) < MIN_MEANS or not np.isfinite(change).all():
            continue
        least = max(JUMP * float(np.quantile(change, 0.9)), MIN_JUMP * float(np.ptp(signal)))
        jumps = np.concatenate([[False], change > least, [False]])
        rows = jumps[np.searchsorted(room.t, t)]
        if rows.mean() < MAX_UNKNOWN:
            unknown |= rows
    return unknown


def _smoothed(t: np.ndarray, signal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A polynomial (n,) through means of MEAN_WIDTH seconds, and its derivative.

    Its degree has the least Bayesian information criterion: a body warms smoothly, and the noise
    of a thermometer would otherwise hide a bias that follows either. The signal stays as it was
    read where the polynomial leaves more than that noise.
    """
    cell = ((t - t[0]) / MEAN_WIDTH).astype(int)
    counts = np.bincount(cell)
    filled = counts > 0
    means = np.bincount(cell, signal)[filled] / counts[filled]
    if filled.sum() < MIN_MEANS or not np.ptp(means):
        return signal, np.zeros(len(t))
    middles = np.bincount(cell, t - t[0])[filled] / counts[filled]
    half = 0.5 * max(float(t[-1] - t[0]), MEAN_WIDTH)
    columns = chebyshev.chebvander(middles / half - 1.0, min(MAX_DEGREE, filled.sum() // 3))
    root = np.sqrt(counts[filled])
    basis, triangle = np.linalg.qr(columns * root[:, None])
    rotated = basis.T @ (means * root)
    missed = float((means**2 * counts[filled]).sum()) - np.cumsum(rotated**2)
    degrees = np.arange(len(rotated))
    rounding = 1e-12 * float((means**2 * counts[filled]).sum())
    criterion = filled.sum() * np.log(np.maximum(missed, rounding)) + degrees * np.log(filled.sum())
    best = int(criterion.argmin()) + 1
    coefficients = np.linalg.solve(triangle[:best, :best], rotated[:best])
    inside = np.clip(t - t[0], middles[0], middles[-1])  # beyond, a polynomial runs away
    at = inside / half - 1.0
    slope = np.asarray(chebyshev.chebval(at, chebyshev.chebder(coefficients)) / half)
    left = np.std(means - columns[:, :best] @ coefficients)
    scatter = deviation(np.diff(means, 2)) / np.sqrt(6.0)
    if left > MAX_EXCESS * scatter:
        return signal, slope
    return np.asarray(chebyshev.chebval(at, coefficients) + slope * (t - t[0] - inside)), slope


def _fixings(recording: Recording, t: np.ndarray, segments: tuple[Segment, ...]) -> np.ndarray:
    """Number of the fixing at each row: blocks of the procedure between which a unit is re-fixed.

    If segments have mounts of their own, a fixing ends where the mount changes. Otherwise the
    positions on a table of several axes are one fixing, and each upright axis of the rates is
    another; a unit is re-fixed right after the last segment of a block, before the move to the
    next.
    """
    manifest = recording.manifest
    mounted = [(segment, segment.mount or manifest.mount) for segment in segments]
    ends = [now.t_start for (_, before), (now, mount) in pairwise(mounted) if mount != before]
    if not any(end <= t[-1] for end in ends):
        several = len(manifest.station.table_axes or ()) > 1
        upright = [
            (segment, "positions" if several and segment.item == "twelve_position" else segment.up)
            for segment in segments if segment.up is not None
        ]  # fmt: skip
        ends = [last.t_end for (last, block), (_, then) in pairwise(upright) if block != then]
    return np.searchsorted(np.sort(ends), t, side="right").astype(float)
