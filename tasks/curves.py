"""Curves for the figures of a certificate, computed from a run beside its results."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from schemas.calibration import Calibration, Item
from schemas.certificate import Certificate
from schemas.recording import AXES, MAX_POINTS, UPS, Curve, Recording, Up
from tasks.calibrate.information.noise import HOUR, MIN_LEVELS, allan_of_rests
from tasks.segments.summarise import ACCEL_COLUMNS, GYRO_COLUMNS
from tasks.specifications.estimate import DEG, ITEMS
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.register import SPECIFICATIONS
from tasks.words.numbers import USUAL_K

DIGITS = 7  # significant, more than any figure shows
LONG_ENOUGH_S = 30.0  # of a rest: as long as the specification's dwell
FEWEST_POINTS = 3  # points that can be off a line
OFFSETS = {"gyro": "gyro_fit_offset", "ahrs": "ahrs_zero_offset"}
TRIAD = ("accel_scale_factor", "accel_cross_coupling", "accel_bias")


def curves_of_run(recording: Recording, calibration: Calibration) -> tuple[Curve, ...]:
    """Residuals over the rate, of the tumble, and the Allan deviation of the rests.

    Each only if the run has the data for it. Nothing for a result with other segments than the
    recording has now, whose means cannot be assigned.
    """
    specification = SPECIFICATIONS[calibration.method]
    evidence = specification.gather(recording)
    now = [segment.segment.name for segment in evidence.segments]
    if now != [segment.name for segment in calibration.segments]:
        return ()
    sensor = specification.rate_sensor
    made: Sequence[Curve] = (
        *rate_residuals(evidence, calibration, sensor),
        *tumble(evidence, calibration),
        *allan_curves(evidence, calibration, sensor),
    )
    return tuple(made)


def chosen(count: int) -> list[int]:
    """Which of so many points a curve has: all, or MAX_POINTS evenly from first to last."""
    return np.linspace(0, count - 1, min(count, MAX_POINTS)).round().astype(int).tolist()


def short(numbers: Iterable[float] | np.ndarray) -> tuple[float, ...]:
    """Numbers rounded to DIGITS."""
    return tuple(float(f"{number:.{DIGITS}g}") for number in numbers)


def thinned(*columns: Sequence[float] | np.ndarray) -> tuple[tuple[float, ...], ...]:
    """Columns (n,) of the points that a curve has."""
    kept = chosen(len(columns[0]))
    return tuple(short(column[i] for i in kept) for column in columns)


def allan_curves(
    evidence: ClauseEvidence, calibration: Calibration, rate_sensor: str
) -> Iterator[Curve]:
    """Overlapping Allan deviation over the averaging time in s: gyro in °/h, accelerometer in m/s².

    U: of the degrees of freedom of white noise. Nothing for a channel whose steps hide its noise,
    and nothing of readings from which a result with terms took something off.
    """
    if calibration.terms:
        return
    triads = ((rate_sensor, GYRO_COLUMNS, "deg/h", DEG * HOUR), ("accel", ACCEL_COLUMNS, "m/s2", 1))
    for quantity, columns, unit, factor in triads[: 1 if rate_sensor == "ahrs" else 2]:
        allan = allan_of_rests(evidence, columns)
        if allan is None or allan.seconds < LONG_ENOUGH_S or len(allan.curve.tau) < MIN_LEVELS:
            continue
        for channel, axis in enumerate(AXES):
            deviation = factor * np.sqrt(allan.curve.variance[:, channel])
            if allan.hidden[channel] or not deviation.all():
                continue
            U = USUAL_K * deviation / np.sqrt(2.0 * allan.curve.white_dof)
            x, y, expanded = thinned(allan.curve.tau, deviation, U)
            yield Curve(
                figure="allan", quantity=quantity, axis=axis, x_unit="s", y_unit=unit,
                x=x, y=y, U=expanded, k=USUAL_K,
            )  # fmt: skip


def rate_residuals(
    evidence: ClauseEvidence, calibration: Calibration, rate_sensor: str
) -> Iterator[Curve]:
    """Reading − K·rate about each axis, less its mean, over the rate of the table; °/s.

    U: of the line at that rate, of the uncertainties of its scale factor and of its offset.
    """
    scale = calibration.items.get(f"{rate_sensor}_scale_factor")
    offset = calibration.items.get(OFFSETS[rate_sensor])
    if scale is None:
        return
    for channel, axis in enumerate(AXES):
        name, K, of_scale = f"gyro_{axis}", scale.value.get(axis), scale.u.get(axis)
        points = [i for i in evidence.points[axis] if name in calibration.segments[i].mean]
        if K is None or of_scale is None or len(points) < FEWEST_POINTS:
            continue
        rate = np.degrees(evidence.rate[points])
        read = np.degrees([calibration.segments[i].mean[name] for i in points])
        off = read - K * rate
        u = np.hypot(of_scale * rate, (offset.u.get(axis) if offset else None) or 0.0)
        order = np.argsort(rate, kind="stable")
        x, y, expanded = thinned(rate[order], (off - off.mean())[order], scale.k * u[order])
        yield Curve(
            figure="rate-residuals", quantity=f"{rate_sensor}_scale_factor", axis=AXES[channel],
            x_unit=ITEMS[OFFSETS[rate_sensor]].unit, y_unit=ITEMS[OFFSETS[rate_sensor]].unit,
            x=x, y=y, U=expanded, k=scale.k,
        )  # fmt: skip


def tumble(evidence: ClauseEvidence, calibration: Calibration) -> Iterator[Curve]:
    """Reading − (K·g + B) of each accelerometer in every position, m/s²; x: their number.

    U: of the model in that position, by the coefficient along the axis up and the bias.
    """
    held = [(up, i) for up in UPS for i in evidence.positions[up]]
    if not held or evidence.gravity is None or not all(name in calibration.items for name in TRIAD):
        return
    held = [held[k] for k in chosen(len(held))]
    labels = tuple(up for up, _ in held)
    for axis in AXES:
        points = [_point(calibration, axis, up, i, evidence.gravity) for up, i in held]
        known = [point for point in points if point is not None]
        if len(known) == len(points):
            y, U = zip(*known, strict=True)
            x = range(1, len(known) + 1)
            yield Curve(
                figure="tumble", quantity="accel_bias", axis=axis, x_unit="1", y_unit="m/s2",
                x=short(x), y=short(y), U=short(U), labels=labels,
                k=calibration.items["accel_bias"].k,
            )  # fmt: skip


def _point(
    calibration: Calibration, axis: str, up: Up, segment: int, gravity: float
) -> tuple[float, float] | None:
    """Residual and U of one accelerometer in one position; None where a number is missing."""
    scale, cross, bias = (calibration.items[name] for name in TRIAD)
    along: Item = scale if up[1] == axis else cross
    element = axis if along is scale else axis + up[1]
    read = calibration.segments[segment].mean.get(f"accel_{axis}")
    K, of_scale = along.value.get(element), along.u.get(element)
    B, of_bias = bias.value.get(axis), bias.u.get(axis)
    if read is None or K is None or B is None or of_scale is None or of_bias is None:
        return None
    felt = gravity if up[0] == "+" else -gravity
    return read - K * felt - B, bias.k * float(np.hypot(of_scale * felt, of_bias))


def history(present: Certificate, earlier: Sequence[Certificate]) -> Iterator[Curve]:
    """Each value by axis less that of the present certificate, over days since its calibration.

    earlier: issued certificates of the same unit, of which those by the same method with an
    earlier day of calibration count; the last point is the present one.
    """
    day, result = present.calibrated_on, present.calibration
    if day is None:
        return
    dated = sorted(
        ((each.calibrated_on, each.number, each.calibration) for each in earlier
         if each.calibrated_on and each.calibrated_on < day
         and each.calibration.method == result.method),
        key=lambda one: one[:2],
    )[1 - MAX_POINTS :]  # fmt: skip
    specification = SPECIFICATIONS[result.method]
    for item in specification.items:
        now = result.items.get(item.key)
        if now is None or item.elements != AXES or item.key not in specification.required:
            continue
        for axis in AXES:
            value, U = now.value.get(axis), now.U.get(axis)
            before = [
                (number, float((when - day).days), was, was_U)
                for when, number, each in dated
                if item.key in each.items
                and (was := each.items[item.key].value.get(axis)) is not None
                and (was_U := each.items[item.key].U.get(axis)) is not None
            ]
            if value is None or U is None or not before:
                continue
            numbers, days, values, expanded = zip(*before, strict=True)
            yield Curve(
                figure="history", quantity=item.key, axis=axis, x_unit="d", y_unit=item.unit,
                x=(*days, 0.0), y=short((*(was - value for was in values), 0.0)),
                U=short((*expanded, U)), k=now.k, labels=numbers,
            )  # fmt: skip
