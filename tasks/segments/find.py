"""Rests and steady turns found from the data, for recordings that carry no labels."""

from dataclasses import dataclass

import numpy as np

from schemas.recording import ACCEL, AXES, GYRO, Manifest, Recording, Segment, Stream, Up
from tasks.motion.table import mean_rate
from tasks.readings.plausibility import runs

WINDOW = 0.5  # s over which quiet is judged
SHORTEST_REST = 1.0  # s: a rest shorter than this is the turning point of a movement
MARGIN = 0.25  # s left off at both ends, where a movement may still fade
ENCODER_STEP = np.radians(0.0025)  # rad: a coarser encoder is judged by its own step
ANGLE_ROUNDING = 1e-6  # rad: smaller differences are arithmetic, not encoder steps
REST_DEVIATIONS = 8.0  # standard deviations above the quietest tenth that are still rest
ALIGNED = np.cos(np.radians(10.0))  # a labelled axis points up within this, biases included
MIN_RECORDING_ROWS = 10
UPRIGHT = np.cos(np.radians(3.0))  # an axis without a label was put upright within this
TURNING_RATE = np.radians(5.0)  # rad/s above the usual reading: a steady turn, not a rest
GRAVITY_LIKE = (5.0, 15.0)  # m/s²: scale factors and biases of a poor unit included
RESTING_RATE = np.radians(1.0)  # rad/s of the table below which it rests


def segments_of(recording: Recording) -> tuple[Segment, ...]:
    """The labelled segments in the order of time, or those found where there are no labels."""
    labelled = recording.manifest.segments or find_segments(recording)
    return tuple(sorted(labelled, key=lambda segment: segment.t_start))


def find_segments(recording: Recording) -> tuple[Segment, ...]:
    """Every rest, and with a table stream every steady turn, in the order of time.

    With a table stream its encoders say where it rests or turns steadily; without one a rest is
    where gyro and accelerometers shake no more than in the quietest tenth of the recording. A
    rest gets `up` where an accelerometer points up or down within 3°: a fixture put it there.
    """
    imu, table = recording.imu, recording.table
    if len(imu) < MIN_RECORDING_ROWS:
        return ()
    quiet = _quiet_rows(imu) if table is None else _steady_rows(recording.manifest, imu.t, table)
    offset = np.median(imu.stack(GYRO)[quiet], axis=0) if quiet.any() else np.zeros(3)
    segments: list[Segment] = []
    for first, end in runs(quiet):
        start, stop = float(imu.t[first]) + MARGIN, float(imu.t[end - 1]) - MARGIN
        if stop - start < SHORTEST_REST:
            continue
        segment = _classified(recording, start, stop, len(segments) + 1, offset)
        if segment is not None:
            segments.append(segment)
    return tuple(segments)


def _quiet_rows(imu: Stream) -> np.ndarray:
    """(n,) bool: no channel moves more than in the recording's quietest tenth."""
    interval = float(np.median(np.diff(imu.t)))
    window = max(3, round(WINDOW / interval))
    quiet = np.ones(len(imu), bool)
    for names in (GYRO, ACCEL):
        values = imu.stack(names)
        if not np.isfinite(values).all():
            values = np.where(np.isfinite(values), values, 0.0)
        shake = np.sqrt(_moving_variance(values, window).sum(axis=1))
        floor = np.quantile(shake[shake > 0], 0.1) if (shake > 0).any() else 0.0
        quiet &= shake <= REST_DEVIATIONS * floor
    return quiet


def _steady_rows(manifest: Manifest, t: np.ndarray, table: Stream) -> np.ndarray:
    """(n,) bool: within the window around each time every table axis keeps its rate."""
    steady = np.ones(len(t), bool)
    for axis in manifest.station.table_axes or ():
        angle = table.columns[f"{axis.name}_angle"]
        steps = np.abs(np.diff(angle))
        step = steps[steps > ANGLE_ROUNDING].min(initial=np.inf)
        tolerance = 4 * max(ENCODER_STEP, step) if np.isfinite(step) else ENCODER_STEP
        before, here, after = (
            np.interp(t + shift, table.t, angle) for shift in (-WINDOW / 2, 0.0, WINDOW / 2)
        )
        steady &= np.abs(after - 2 * here + before) <= tolerance
    return steady


def _moving_variance(values: np.ndarray, window: int) -> np.ndarray:
    from scipy.ndimage import uniform_filter1d  # late: recordings with labels do not need it

    centred = values - values.mean(axis=0)
    mean = uniform_filter1d(centred, window, axis=0)
    square = uniform_filter1d(centred**2, window, axis=0)
    return np.maximum(square - mean**2, 0.0)


def _classified(
    recording: Recording, start: float, stop: float, number: int, offset: np.ndarray
) -> Segment | None:
    """The interval as a segment: a rest, or a steady turn that the encoders confirm.

    offset: (3,) what the gyro reads in most quiet rows, rad/s.
    """
    name = f"found_{number:03d}"
    rest = Segment(name=name, kind="static", t_start=start, t_end=stop)
    rate = mean_rate(recording, rest)
    if rate is None or np.linalg.norm(rate) < RESTING_RATE:
        rows = recording.imu.rows(start, stop)
        gyro = recording.imu.stack(GYRO, rows).mean(axis=0)
        if rate is None and np.linalg.norm(gyro - offset) > TURNING_RATE:
            return None  # it turns, and how fast was not recorded
        accel = recording.imu.stack(ACCEL, rows)
        up = up_of(np.median(accel, axis=0), UPRIGHT) if len(accel) else None
        return rest.model_copy(update={"up": up})
    axis = int(np.abs(rate).argmax())
    if abs(rate[axis]) < ALIGNED * np.linalg.norm(rate):
        return None
    return rest.model_copy(
        update={"kind": "rate", "axis": AXES[axis], "rate_deg_s": float(np.degrees(rate[axis]))}
    )


def up_of(accel: np.ndarray, within: float = ALIGNED) -> Up | None:
    """The axis along which a (3,) mean specific force lies, with its sign.

    within: cosine of the largest angle, 10° unless given.

    None where no axis does, or where what is read is not gravity at all.
    """
    axis, size = int(np.abs(accel).argmax()), float(np.linalg.norm(accel))
    if not GRAVITY_LIKE[0] < size < GRAVITY_LIKE[1] or abs(accel[axis]) < within * size:
        return None
    sign = "+" if accel[axis] > 0 else "-"
    return f"{sign}{AXES[axis]}"  # type: ignore[return-value]


def shown_instead(label: Segment, accel: np.ndarray) -> str | None:
    """The axis that gravity shows up in a rest labelled otherwise, `none` for no axis, by a (3,)
    mean specific force; None where they agree, or one of them tells nothing.
    """
    if label.kind != "static" or label.up is None or not np.isfinite(accel).all():
        return None
    shown = up_of(accel)
    return None if shown == label.up else shown or "none"


# A specification's requirements on every point and on the environment.


@dataclass(frozen=True)
class Conditions:
    """Numbers of a specification and the clauses they come from.

    dwell_s: least time at each point, s. steadiness: relative change of a held rate.
    temperature_degc, humidity_percent: lowest and highest value of the air.
    """

    dwell_s: float
    dwell_clause: str
    steadiness: float
    steadiness_clause: str
    temperature_degc: tuple[float, float]
    humidity_percent: tuple[float, float]
    environment_clause: str
