"""Unit and table on one time base: the same motion at the same time throughout the run."""

from collections.abc import Iterator

import numpy as np

from schemas.recording import AXES, GYRO, MEASURED, TRIADS, Recording, Stream
from schemas.text import Remark
from tasks.motion.samples import FARTHEST, continuous, covered, gaps
from tasks.motion.table import mount_of, payload_attitude, table_angles
from tasks.motion.whole import polled_within
from tasks.readings.stamps import in_packets
from tasks.run_validity.remark import run_remark
from tasks.segments.summarise import (
    ACCEL_COLUMNS,
    CHANNELS,
    GYRO_COLUMNS,
    MIN_ROWS,
    SegmentMean,
    extreme_steps,
    rows_of,
)
from tasks.specifications.evidence import ClauseEvidence
from tasks.words import message
from tasks.words.numbers import moment, plain

LARGEST = 0.2  # s: more reaches from a ramp into what is measured
INTERVAL = 0.05  # s at which both are compared
SEARCHED = 10.0  # s to either side
PARTS = 4  # of the run, so that a drifting clock shows
INTERRUPTION = 1.0  # s without a row, as where a run was interrupted: nothing is known of its rates
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
    limit = max(LARGEST, interval)  # of rows farther apart no shift by one is known
    if abs(worst) > limit:
        yield run_remark(
            "clocks_apart", run="invalid", delay=f"{worst:+.2f}", limit=f"{limit:g}",
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
    angles = continuous(table, tuple(f"{axis.name}_angle" for axis in axes))
    is_known = _recorded(imu.t, at) & _recorded(table.t, at)
    by_table = is_known * np.abs(_steps(at, table.t, angles)).sum(axis=1) / interval
    gyro = np.nan_to_num(imu.stack(GYRO))
    turned = np.cumsum(0.5 * (gyro[1:] + gyro[:-1]) * np.diff(imu.t)[:, None], axis=0)
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
    gaps = np.flatnonzero(np.diff(t) > INTERRUPTION)
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


# Missing data: samples, rows, triads, table readings.

LARGEST_SHARE = 0.01  # of a segment's samples, or of the run's, that may be lost
LATE_STEP = 1.5  # sampling intervals: a longer step after which stamps stay late is a gap
POLLED_GAP = 5.0  # s: angles that are asked for one by one come as they can
BEYOND = 1.0  # s by which a segment may begin before the first sample, or end after the last


def lost_data_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """What is missing in some segments, or in the whole recording."""
    recording, segments = evidence.recording, evidence.segments
    for segment in segments:
        yield from _lost(recording, segment)
        yield from _beyond(recording, segment)
    yield from _share("imu", recording.imu, segments)
    if recording.table is not None and not polled_within(recording):
        yield from _share("table", recording.table, segments)
    yield from _without_rows(recording)
    yield from _null_rows(recording, segments)
    yield from _table_gap(recording, segments)


def _share(stream: str, rows: Stream, segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Samples of a stream that are missing in all segments together, by its sampling rate."""
    if len(rows) < 2 or not segments:
        return
    seconds = sum(s.segment.t_end - s.segment.t_start for s in segments)
    found = 0
    for s in segments:
        here = rows.rows(s.segment.t_start, s.segment.t_end)
        found += here.stop - here.start + 1  # one more for the ends
    if found >= (1.0 - LARGEST_SHARE) * seconds / extreme_steps(rows.t)[0]:
        return  # whatever the usual interval is
    packets = in_packets(rows.t)
    interval = float(np.median(np.diff(rows.t))) if packets is None else packets.interval
    share = 1.0 - found * interval / seconds
    if share > LARGEST_SHARE:
        yield run_remark(
            "lost_share", run="invalid", stream=stream, share=plain(100 * share, 2),
            limit=f"{100 * LARGEST_SHARE:g}",
        )  # fmt: skip


def _lost(recording: Recording, segment: SegmentMean) -> Iterator[Remark]:
    """Samples missing between two time stamps."""
    shortest, longest = segment.intervals
    if segment.rows < 3 or longest <= LATE_STEP * shortest:  # whatever the usual one is
        return
    t = recording.imu.t[segment.place]
    steps = np.diff(t)
    interval = float(np.median(steps))
    before = gaps(t, interval, LATE_STEP - 1.0)
    if not len(before):
        return
    lost = int(np.round(steps[before] / interval - 1).sum())
    worst = before[int(steps[before].argmax())]
    name, at = segment.segment.name, t[worst]
    yield run_remark(
        "lost_samples", name,
        run="invalid" if lost > LARGEST_SHARE * segment.rows else "valid",
        segment=name, lost=lost, gaps=len(before), longest=f"{steps[worst]:.3f}",
        time=f"{at:.2f}",
    )  # fmt: skip


def _beyond(recording: Recording, segment: SegmentMean) -> Iterator[Remark]:
    """A segment that reaches beyond the recording: wrong times, or samples that were cut off."""
    label, t = segment.segment, recording.imu.t
    if label.t_start < t[0] - BEYOND or label.t_end > t[-1] + BEYOND:
        yield run_remark(
            "beyond_recording", label.name, segment=label.name,
            start=moment(label.t_start), end=moment(label.t_end),
            first=moment(t[0]), last=moment(t[-1]),
        )  # fmt: skip


def _without_rows(recording: Recording) -> Iterator[Remark]:
    """Labelled segments that the recording has no rows of, or too few for a mean."""
    measured = [s for s in recording.manifest.segments or () if s.kind in MEASURED]
    counts = {s.name: rows_of(recording, s) for s in measured}
    empty = {name: rows for name, rows in counts.items() if rows < MIN_ROWS}
    if empty:
        listed = ", ".join(f"{name} {rows}" for name, rows in empty.items())
        yield run_remark("without_rows", *empty, count=len(empty), listed=listed)


def _null_rows(recording: Recording, segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Labelled segments in which a triad has null rows, and was not taken for them."""
    imu = recording.imu
    measured = [s for s in recording.manifest.segments or () if s.kind in MEASURED]
    for triad in TRIADS:
        values = imu.columns.get(triad[0])
        # The smallest is NaN where any is.
        if values is None or not np.isnan(values.min(initial=0.0)) or np.isnan(values).all():
            continue
        counts = {
            s.name: int(np.isnan(values[imu.rows(s.t_start, s.t_end)]).sum()) for s in measured
        }
        first = CHANNELS.index(triad[0])
        taken = {s.segment.name for s in segments if np.isfinite(s.mean[first])}
        nulls = {name: count for name, count in counts.items() if count and name not in taken}
        if nulls:
            yield run_remark(
                "null_rows", *nulls, run="valid",
                triad=triad[0].removesuffix("_x"), count=len(nulls),
                listed=", ".join(f"{segment} {count}" for segment, count in nulls.items()),
            )  # fmt: skip


def _table_gap(recording: Recording, segments: tuple[SegmentMean, ...]) -> Iterator[Remark]:
    """Segments that the table stream, where there is one, does not cover."""
    table, imu = recording.table, recording.imu
    if table is None or not recording.manifest.station.table_axes:
        return
    farthest = POLLED_GAP if polled_within(recording) else FARTHEST
    bare = imu.t[~covered(table.t, imu.t, farthest=farthest)]
    first = {}
    for s in segments:
        start, stop = np.searchsorted(bare, (s.t_start, s.t_end))
        if stop > start:
            first[s.segment.name] = float(bare[start])
    if first:
        gaps = tuple(
            message("validity-table-gap-from", segment=name, time=f"{t:.2f}")
            for name, t in first.items()
        )
        yield run_remark("table_gap", *first, run="invalid", count=len(first), gaps=gaps)


# The table's encoders, checked against themselves, gravity and the gyros.

JUMP = np.radians(0.5)  # rad: no encoder's noise or step
ACCELERATION = np.radians(2000.0)  # rad/s² that no turntable has
ADJACENT = 1.5  # usual intervals: what lies farther apart is no step of the encoder
ATTITUDE = 0.3  # m/s²: two degrees of tilt beside what unit and mounting do in all rests
GAIN = 0.05  # of a held rate, by which the gyro may follow otherwise than in the other runs
SLOW = np.radians(5.0)  # rad/s: below it a zero looks like a gain


def encoder_remarks(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Encoders that jump, or that show another attitude or rate than the unit feels."""
    recording = evidence.recording
    axes, table = recording.manifest.station.table_axes, recording.table
    if table is None or not axes:
        return
    for axis in axes:
        yield from _jumps(axis.name, table, polled_within(recording))
    yield from _attitude(evidence)
    yield from _gain(evidence)


def _jumps(axis: str, table: Stream, half_width_s: float) -> Iterator[Remark]:
    """Samples between which no table can have turned so far.

    half_width_s: of the time of an angle that is polled, at any interval.
    """
    if len(table) < 4:
        return
    steps, angle = np.diff(table.t), table.columns[f"{axis}_angle"]
    usual = float(np.median(steps))
    turned = np.diff(angle)
    bend = np.abs((np.diff(turned) + np.pi) % (2.0 * np.pi) - np.pi)  # encoders may start anew
    near = np.maximum(steps[1:], steps[:-1]) < ADJACENT * usual
    limit = np.full(len(bend), max(JUMP, ACCELERATION * usual**2))
    if half_width_s:
        speed = np.abs(turned / steps)
        off = np.abs(np.diff(steps)) + 4.0 * half_width_s
        limit += off * np.maximum(speed[1:], speed[:-1])
    jumps = np.flatnonzero(near & (bend > limit))
    if len(jumps):
        worst = int(jumps[bend[jumps].argmax()])
        yield run_remark(
            "encoder_jump", run="invalid", axis=axis, count=len(jumps),
            size=f"{np.degrees(bend[worst]):.2f}", time=f"{table.t[worst + 1]:.2f}",
        )  # fmt: skip


def _attitude(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Rests in which gravity lies otherwise in the unit than the encoders have it."""
    recording, rests, up = evidence.recording, [], []
    for segment in evidence.segments:
        angles = table_angles(recording, segment.segment)
        if segment.segment.kind == "static" and segment.has_accel and len(angles):
            payload = payload_attitude(recording.manifest.station, angles.mean(axis=0))
            rests.append(segment)
            up.append((payload @ mount_of(recording.manifest, segment.segment))[2])
    if len(rests) <= 4:
        return
    design = np.column_stack([np.ones(len(rests)), up])
    felt = np.array([rest.mean[ACCEL_COLUMNS] for rest in rests])
    left = felt - design @ np.linalg.lstsq(design, felt, rcond=None)[0]
    away = np.abs(left).max(axis=1)
    if away.max() > ATTITUDE:
        names = [rests[i].segment.name for i in np.flatnonzero(away > ATTITUDE)]
        yield run_remark(
            "attitude_contradicted", *names, run="invalid", count=len(names), first=names[0],
            left=f"{away.max():.2f}", limit=f"{ATTITUDE:g}",
        )  # fmt: skip


def _gain(evidence: ClauseEvidence) -> Iterator[Remark]:
    """Held rates by the encoders that the gyro follows otherwise than the other rates."""
    rests = evidence.means[evidence.of_kind("static")][:, GYRO_COLUMNS]
    rests = rests[np.isfinite(rests).all(axis=1)]
    zero = np.median(rests, axis=0) if len(rests) else np.zeros(3)
    for number, axis in enumerate(AXES):
        points = [
            i
            for i, point in evidence.turning_points.items()
            if evidence.labels[i].axis == axis and point.by_table and abs(point.rate) > SLOW
        ]
        if len(points) < 3 or not len(rests):
            continue
        rates = np.array([evidence.turning_points[i].rate for i in points])
        gains = (evidence.means[points, number] - zero[number]) / rates
        away = np.abs(gains - np.median(gains)) > GAIN * abs(np.median(gains))
        names = [evidence.labels[points[i]].name for i in np.flatnonzero(away)]
        if names:
            yield run_remark(
                "gyro_contradicts_encoder", *names, run="invalid", axis=axis, count=len(names),
                first=names[0], percent=f"{100 * GAIN:g}",
            )  # fmt: skip
