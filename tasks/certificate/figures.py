"""The figures of a certificate: which there are, their captions, and how they are drawn.

What is written in a figure is the same in every language: symbols, units, axes. It is drawn as
outlines, so that the PDF needs no font for it and holds no number twice.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from schemas.calibration import Calibration, Item
from schemas.certificate import Certificate
from schemas.recording import AXES, MAX_POINTS, UPS, Curve, FigureName, Recording, Up
from tasks.calibrate.information.noise import HOUR, MIN_LEVELS, allan_of_rests
from tasks.rendering import AFTER, BEFORE, GREY, INK, PALE, draw
from tasks.segments.summarise import ACCEL_COLUMNS, GYRO_COLUMNS
from tasks.specifications.estimate import DEG, ITEMS
from tasks.specifications.evidence import ClauseEvidence
from tasks.specifications.register import SPECIFICATIONS
from tasks.words import Message, clauses, message
from tasks.words.numbers import USUAL_K, plain, power_of_ten, unit_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# The panels of a certificate's figures, drawn by matplotlib, with symbols and units only.

COLOURS = {"x": AFTER, "y": BEFORE, "z": "#009e73"}  # as in the house's charts, told apart in print
MARKS = {"x": "o", "y": "s", "z": "^"}
SIZE = 2.6  # pt, of a mark
BAR = 0.7  # pt, of the line of a U
PER_CENT, LARGEST_PPM = 1e-4, 1e3  # per ppm; from so many on an axis is in per cent

Panel = Callable[["Axes", Sequence[Curve], int], None]


def rate_residuals(axes: "Axes", curves: Sequence[Curve], _: int) -> None:
    """Residuals of one axis over the rate, and ± U about zero."""
    (curve,) = curves
    factor, unit = _power(curves)
    x, y, U = np.array(curve.x), factor * np.array(curve.y), factor * np.array(curve.U)
    axes.fill_between(x, -U, U, color=PALE, linewidth=0)
    axes.axhline(0.0, color=GREY, linewidth=0.5)
    axes.plot(x, y, MARKS["x"], color=COLOURS["x"], markersize=SIZE)
    axes.locator_params(nbins=5)
    axes.set_title(curve.axis.upper())
    axes.set_xlabel(f"ω / ({unit_text(curve.x_unit)})", labelpad=1.5)
    axes.set_ylabel(f"Δω / ({unit})", labelpad=1.5)


def tumble(axes: "Axes", curves: Sequence[Curve], _: int) -> None:
    """Residuals of one accelerometer with ± U, position by position, named by the axis up."""
    (curve,) = curves
    factor, unit = _power(curves)
    axes.axhline(0.0, color=GREY, linewidth=0.5)
    _bars(axes, curve, factor, "x")
    ticks, names, place = [], [], 0
    for up, same in groupby(curve.labels):
        count = len(list(same))
        ticks.append(np.mean(curve.x[place : place + count]))
        names.append(up.upper().replace("-", "−"))
        place += count
    axes.set_xticks(ticks, names)
    axes.locator_params(axis="y", nbins=5)
    axes.set_title(curve.axis.upper())
    axes.set_ylabel(f"Δa / ({unit})", labelpad=1.5)


def allan(axes: "Axes", curves: Sequence[Curve], _: int) -> None:
    """Allan deviation of a triad over the averaging time, with ± U."""
    from matplotlib.ticker import LogLocator, NullLocator

    axes.set(xscale="log", yscale="log")
    for curve in curves:
        _bars(axes, curve, 1.0, curve.axis)
    for ticks in (axes.xaxis, axes.yaxis):
        ticks.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=9))
        ticks.set_minor_locator(NullLocator())
        ticks.set_major_formatter(lambda value, _: _tick(value))
    axes.set_xlabel(f"τ / {unit_text(curves[0].x_unit)}", labelpad=1.5)
    letter = "a" if curves[0].quantity == "accel" else "ω"
    axes.set_ylabel(f"σ({letter}) / ({unit_text(curves[0].y_unit)})", labelpad=1.5)
    axes.legend(borderpad=0, handletextpad=0.2)


def history(axes: "Axes", curves: Sequence[Curve], day: int) -> None:
    """What a coefficient was, less what it is, over the day of the calibration, with ± U."""
    from matplotlib.dates import AutoDateLocator, DateFormatter, date2num

    factor, unit = _power(curves)
    origin = float(date2num(np.datetime64("0001-01-01", "D") + (day - 1)))
    axes.axhline(0.0, color=GREY, linewidth=0.5)
    for curve in curves:
        _bars(axes, curve, factor, curve.axis, origin, line=0.5)
    axes.xaxis.set_major_locator(AutoDateLocator(minticks=2, maxticks=5))
    axes.xaxis.set_major_formatter(DateFormatter("%Y-%m"))
    axes.margins(x=0.08)
    axes.locator_params(axis="y", nbins=5)
    item = ITEMS[curves[0].quantity]
    under = item.subscript.partition("{")[0]
    symbol = rf"$\mathit{{{item.letter}}}_\mathrm{{{under}}}$" if under else item.letter
    axes.set_ylabel(f"Δ{symbol} / ({unit})" if unit else f"Δ{symbol}", labelpad=1.5)
    axes.legend(borderpad=0, handletextpad=0.2, ncols=3, loc="lower left", bbox_to_anchor=(0, 0.96))


PANELS: dict[FigureName, Panel] = {
    "rate-residuals": rate_residuals, "tumble": tumble, "allan": allan, "history": history,
}  # fmt: skip


def _bars(
    axes: "Axes", curve: Curve, factor: float, axis: str, origin: float = 0.0, line: float = 0.0
) -> None:
    x = origin + np.array(curve.x)
    y, U = factor * np.array(curve.y), factor * np.array(curve.U)
    axes.errorbar(
        x, y, U, fmt=MARKS[axis], color=COLOURS[axis], markersize=SIZE, elinewidth=BAR,
        linestyle="-" if line else "none", linewidth=line, label=curve.axis.upper(),
    )  # fmt: skip


def _power(curves: Sequence[Curve]) -> tuple[float, str]:
    """By what the values are multiplied so that they can be read, and the unit that they then have.

    A power of a thousand, by the largest value with its U; thousands of ppm are per cent.
    """
    largest = max(abs(y) + U for curve in curves for y, U in zip(curve.y, curve.U, strict=True))
    if curves[0].y_unit == "ppm" and largest >= LARGEST_PPM:
        return PER_CENT, "%"
    thousands = math.floor(math.log10(largest) / 3.0) if largest > 0.0 else 0
    named = unit_text(curves[0].y_unit).removeprefix("1")
    power = "" if thousands == 0 else power_of_ten(3 * thousands).removeprefix("×").strip()
    return 10.0 ** (-3 * thousands), " ".join(filter(None, (power, named)))


def _tick(value: float) -> str:
    """A number of a logarithmic axis; within three decades of one in full."""
    return f"{value:g}" if 1e-3 <= value < 1e4 else plain(value, digits=1)


WIDTH, PANEL, FRAME = 476.0, 92.0, 34.0  # pt: of the page's text; of a row of panels; beside it
IN_A_ROW = 3
OUTLINED: dict[str, Any] = {
    "svg.fonttype": "path", "font.size": 7.0, "axes.labelsize": 7.0, "axes.titlesize": 7.5,
    "axes.labelcolor": INK, "axes.titleweight": "normal", "legend.fontsize": 7.0,
    "axes.titley": 1.0,  # nothing is above the panel: to look for it takes a fifth of the drawing
    "axes.linewidth": 0.5, "xtick.major.width": 0.5, "ytick.major.width": 0.5,
    "xtick.major.size": 2.0, "ytick.major.size": 2.0, "axes.edgecolor": GREY,
}  # fmt: skip


@dataclass(frozen=True)
class PrintedFigure:
    """A figure: its name, its title, and the sentence that says what is drawn."""

    name: FigureName
    title: Message
    caption: Message


def figures(certificate: Certificate) -> tuple[PrintedFigure, ...]:
    """Every figure for which there are curves, in the order in which they are printed."""
    found = []
    for name in get_args(FigureName):
        curves = of_figure(certificate, name)
        if curves:
            earlier = tuple(dict.fromkeys(label for curve in curves for label in curve.labels))
            of_history = {"certificates": clauses(earlier)} if name == "history" else {}
            caption = message(f"certificate-figure.{name}-caption", **of_history)
            title = message(f"certificate-figure.{name}")
            found.append(PrintedFigure(name, title, caption))
    return tuple(found)


def of_figure(certificate: Certificate, name: FigureName) -> tuple[Curve, ...]:
    """The curves of one figure."""
    return tuple(curve for curve in certificate.curves if curve.figure == name)


def drawn(certificate: Certificate) -> dict[str, str]:
    """Each figure as SVG, by its name; the same curves give the same bytes."""
    day = certificate.calibrated_on
    return {
        each.name: _svg(each.name, of_figure(certificate, each.name), day.toordinal() if day else 0)
        for each in figures(certificate)
    }


@lru_cache(maxsize=32)  # draft, check and issue draw the same ones
def _svg(name: FigureName, curves: tuple[Curve, ...], day: int) -> str:
    """day: of the calibration, days since year 1, from which a history counts."""
    by_axis = name in ("rate-residuals", "tumble")
    # The curves of each panel: of one axis, or of one quantity.
    keys = [curve.axis if by_axis else curve.quantity for curve in curves]
    panels = [
        tuple(curve for curve, key in zip(curves, keys, strict=True) if key == one)
        for one in dict.fromkeys(keys)
    ]
    columns = min(len(panels), IN_A_ROW if len(panels) != IN_A_ROW + 1 else 2)
    rows = -(-len(panels) // columns)
    height = rows * PANEL + (rows - 1) * FRAME + FRAME

    def content(figure: "Figure") -> None:
        figure.set_layout_engine("none")  # it would cost as much again as the drawing
        grid = figure.subplots(rows, columns, squeeze=False, gridspec_kw={
            "left": 40 / WIDTH, "right": 1 - 14 / WIDTH, "bottom": 22 / height,
            "top": 1 - 12 / height, "wspace": 0.28, "hspace": FRAME / PANEL,
        })  # fmt: skip
        for axes, panel in zip(grid.flat, panels, strict=False):
            PANELS[name](axes, panel, day)
        for unused in grid.flat[len(panels) :]:
            unused.set_axis_off()

    return draw(name, WIDTH, height, content, OUTLINED)


# Curves for the figures of a certificate, computed from a run beside its results.


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
        *residual_curves(evidence, calibration, sensor),
        *tumble_curves(evidence, calibration),
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


def residual_curves(
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


def tumble_curves(evidence: ClauseEvidence, calibration: Calibration) -> Iterator[Curve]:
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


def history_curves(present: Certificate, earlier: Sequence[Certificate]) -> Iterator[Curve]:
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
