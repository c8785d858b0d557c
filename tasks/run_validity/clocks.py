"""Unit and table on one time base: the same motion at the same time throughout the run."""

from collections.abc import Iterator

import numpy as np

from schemas.recording import GYRO, Recording
from schemas.text import Remark
from tasks.motion.samples import running_on
from tasks.run_validity.remark import run_remark
from tasks.specifications.evidence import ClauseEvidence

LARGEST = 0.2  # s: more reaches from a ramp into what is measured
INTERVAL = 0.05  # s at which both are compared
SEARCHED = 10.0  # s to either side
PARTS = 4  # of the run, so that a drifting clock shows
GAP = 1.0  # s without a row, as where a run was interrupted: nothing is known of its rates
TIME_BASE = 3e-5  # relative: three times what Table 1 of JJF 2003 allows a rate
FEWEST_POINTS = 4  # rates that show the same
COVERED = 3.0  # standard uncertainties of the ratio, by how the points scatter
MOVING = np.radians(5.0)  # rad/s: a part in which nothing turns as fast says nothing


def clock_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Parts of the run in which what the gyros read lies beside what the encoders show."""
    recording = evidence.recording
    if recording.table is None or len(recording.imu) < 2:
        return
    interval = max(INTERVAL, float(np.median(np.diff(recording.imu.t))))
    rates = _rates(recording, interval)
    if rates is None:
        return
    parts = zip(*(np.array_split(each, PARTS) for each in rates), strict=True)
    found = (_delay(by_unit, by_table, interval) for by_unit, by_table in parts)
    delays = [delay for delay in found if delay is not None]
    worst = max(delays, key=abs, default=0.0)
    if abs(worst) > LARGEST:
        yield run_remark(
            "clocks_apart", run="invalid", delay=f"{worst:+.2f}", limit=f"{LARGEST:g}",
        )  # fmt: skip


def time_base_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Rates that all are by the recording's time another than the table was set to.

    The table turns by its own clock, and holds what it is set to; the recording is stamped by
    another. Where both disagree, one of them is wrong, and every scale factor with it.
    """
    points = [
        point
        for point in evidence.turning_points.values()
        if point.by_table and point.shown is not None and not (point.contradicted or point.unsteady)
    ]
    label = np.array([point.label for point in points])
    shown = np.array([point.shown for point in points], float)
    if len(points) < FEWEST_POINTS or not label.any():
        return
    ratio = float(label @ shown / (label @ label))
    left = shown - ratio * label
    u = float(np.sqrt(left @ left / (len(points) - 1) / (label @ label)))
    if abs(ratio - 1.0) > TIME_BASE + COVERED * u:
        yield run_remark(
            "time_base", off=f"{1e6 * (ratio - 1.0):+.0f}", limit=f"{1e6 * TIME_BASE:.0f}",
            count=len(points),
        )  # fmt: skip


def _rates(recording: Recording, interval: float) -> tuple[np.ndarray, np.ndarray] | None:
    """Mean rates (m,) of the unit over each interval (s) by its gyros and by the encoders, rad/s.

    None where one of both was not recorded, or for too short a time.
    """
    table, imu, axes = recording.table, recording.imu, recording.manifest.station.table_axes
    if table is None or not axes or not set(GYRO) <= set(imu.columns) or len(table) < 2:
        return None
    start, end = max(table.t[0], imu.t[0]), min(table.t[-1], imu.t[-1])
    at = np.arange(start, end, interval)
    if len(at) < PARTS * SEARCHED / interval:
        return None
    angles = running_on(table.stack(tuple(f"{axis.name}_angle" for axis in axes)))
    is_known = _recorded(imu.t, at) & _recorded(table.t, at)
    by_table = is_known * np.abs(_steps(at, table.t, angles)).sum(axis=1) / interval
    gyro = np.nan_to_num(imu.stack(GYRO))
    turned = np.cumsum(gyro[:-1] * np.diff(imu.t)[:, None], axis=0)
    vector = _steps(at, imu.t, np.vstack([np.zeros(3), turned])) / interval
    by_unit = np.linalg.norm(vector - _bias(vector[is_known & (by_table < MOVING)]), axis=1)
    return is_known * by_unit, by_table


def _steps(at: np.ndarray, t: np.ndarray, values: np.ndarray) -> np.ndarray:
    """By how much the columns of values (n, k) at the times t (n,) change from one of the times
    at (m + 1,) to the next: (m, k)."""
    return np.diff([np.interp(at, t, column) for column in values.T], axis=1).T


def _bias(still: np.ndarray) -> np.ndarray:
    """What the gyros read while the table stands, from rates (k, 3): (3,); 0 if it never does.

    Not of the whole run, which may turn for most of its time.
    """
    return np.median(still, axis=0) if len(still) else np.zeros(3)


def _recorded(t: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Which intervals between the times at (m + 1,) touch no gap in t (n,): (m,) true or false."""
    gaps = np.flatnonzero(np.diff(t) > GAP)
    behind = np.searchsorted(t[gaps + 1], at[:-1], side="right")  # gaps that end before it
    begun = np.searchsorted(t[gaps], at[1:], side="left")
    return np.asarray(begun == behind)


def _delay(by_unit: np.ndarray, by_table: np.ndarray, interval: float) -> float | None:
    """By how many seconds the unit is late: where both rates (m,), `interval` s apart, agree best.

    None where nothing turns, or nothing starts or stops.
    """
    unit, table = (np.minimum(rate, np.quantile(rate, 0.99)) for rate in (by_unit, by_table))
    unit, table = unit - unit.mean(), table - table.mean()
    if table.std() < MOVING or unit.std() < MOVING:
        return None
    reach = round(SEARCHED / interval)
    length = len(unit)
    spectrum = np.fft.rfft(unit, 2 * length) * np.conj(np.fft.rfft(table, 2 * length))
    alike = np.fft.irfft(spectrum, 2 * length)
    lags = np.arange(-reach, reach + 1)
    return float(lags[int(alike[lags].argmax())]) * interval
