"""What is found of a recording on sight, once, for import, calibration, validity and explanation.

Wrong units, axes and clocks, columns that are no reading, rows that are held, a log too coarse.

By the means of the segments beside what the unit went through there, from encoders or from labels:
a matrix of what is read of each input, as a signed permutation times a factor. Only what fits a
usual mistake, and leaves next to nothing of the readings, is named; anything else is left to those
who search. Labels that are shifted as a whole are found by the rows that contradict them.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np
from pydantic import TypeAdapter, ValidationError

from schemas.recording import (
    ACCEL,
    AXES,
    GYRO,
    SEEN,
    SI_PER_UNIT,
    TRIADS,
    Recording,
    Segment,
    Stream,
)
from schemas.text import Remark, RunVerdict, Seen
from tasks.motion.encoders import gives_angles
from tasks.motion.samples import in_blocks
from tasks.motion.whole import STANDARD_GRAVITY, attitude_stream, gravity_of, unit_vector
from tasks.readings.axes import (
    DEG,
    EXCITED,
    FEWEST_SEGMENTS,
    MATRICES,
    NEAR_FACTOR,
    SegmentMeans,
    TriadMatrix,
    common_factor,
    directions_of,
    fitting,
    matrix_by_segments,
    matrix_of_directions,
    responses,
    segment_means,
    sizes_beside_poses,
    sizes_by_rates,
)
from tasks.readings.robust import median
from tasks.words import Message, message, remark
from tasks.words.numbers import plain

# What is found on sight: one remark for each thing, made once, and shown by all in its words.

# What makes everything else that a recording shows doubtful, and comes first.
KINDS = ("time_unit", "gravity_removed", "force_unit", "rate_unit", "table_unit", "label_unit",
         "axes", "mount", "column_exchanged", "column_copied", "labels_shifted",
         "rate_setting", "force_setting", "clock_set", "restarted", "no_data", "held_rows",
         "coarse_log")  # fmt: skip


def found_on_sight(
    kind: str, sentence: Message, segments: tuple[str, ...] = (), run: RunVerdict = "invalid"
) -> Remark:
    """kind: its catalogue name. sentence: what is wrong, by how much, and how to import it right or
    what to do; of an option that of `mimucal import`.
    """
    return remark(kind, sentence, segments, blocks_pass=run != "valid", run=run)


def ratio_text(value: float) -> str:
    return f"{value:.4g}" if value > 1 else f"1/{1.0 / value:.4g}"


# Times in a smaller unit than seconds.

SLOWEST = 0.25  # s between rows, from which the time may be in a smaller unit
FASTEST = 2e4  # Hz
TIMES = ((1e3, "ms"), (1e6, "us"), (1e9, "ns"))
MOST_LABELS = 0.9  # of the labels
TURNED = np.radians(30.0)  # between rests: a move
LONGEST_WAY = 100.0  # times the angle between two rests that a unit turns from one to the other
AS_FAR = 2.5  # times: axes that turn together, noise


def wrong_time(
    recording: Recording, segments: Sequence[Segment], means: SegmentMeans
) -> Remark | None:
    """Times in a smaller unit than s: by the rates of encoders, by the way between rests, or by
    labels and streams of which one lasts a thousand times as long.
    """
    t = recording.imu.t
    beyond = [segment.t_end for segment in segments if segment.t_start > t[-1]]
    if beyond and len(beyond) > MOST_LABELS * len(segments):
        for factor, unit in TIMES:
            if abs(np.log(max(beyond) / t[-1] / factor)) < np.log(2.0):
                return _time_sentence("labels", max(beyond), factor, f"--units labels={unit}")
    if t[-1] - t[0] < 0.5 * SLOWEST * (len(t) - 1):  # most of the steps are shorter
        return None
    interval = float(np.median(np.diff(t)))
    if interval < SLOWEST:
        return None
    for factor, unit in TIMES:
        if interval / factor > 1.0 / 4.0 or interval / factor < 1.0 / FASTEST:
            continue
        if _by_encoders(recording, factor) or _by_ways(recording, segments, means, factor):
            return _time_sentence("recording", interval, factor, f"--units t={unit}")
    return None


def _time_sentence(what: str, value: float, factor: float, option: str) -> Remark:
    unit = option.rpartition("=")[2]
    return found_on_sight(
        "time_unit",
        message("plausibility-time", what=what, value=f"{value:.4g}", factor=f"{factor:.0f}",
                unit=unit, option=option),
    )  # fmt: skip


def _by_encoders(recording: Recording, factor: float) -> bool:
    """Whether gyros turn as far as encoders once their times are divided."""
    ratio = turned_ratio(recording)
    return ratio is not None and 1.0 / AS_FAR < ratio / factor < AS_FAR


def turned_ratio(recording: Recording) -> float | None:
    """How far the gyros turned in all, over how far the encoders did; None where either is not
    known.
    """
    imu, table = recording.imu, recording.table
    gyro = imu.stack(GYRO)
    if table is None or not np.isfinite(gyro).all():
        return None
    angles = [v for name, v in table.columns.items() if name.endswith("_angle")]
    turned = sum(float(np.abs(np.diff(angle)).sum()) for angle in angles)
    speed = np.linalg.norm(gyro - np.median(gyro, axis=0), axis=1)
    read = float(np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(imu.t)))
    return read / turned if turned > np.pi else None


def _by_ways(
    recording: Recording, segments: Sequence[Segment], means: SegmentMeans, factor: float
) -> bool:
    """Whether between all rests the gyros turn by far too much for what gravity turned by, and
    once the times are divided by enough.
    """
    ratios = ways(recording, segments, means)
    return (
        len(ratios) > FEWEST_SEGMENTS and min(ratios) > LONGEST_WAY and min(ratios) / factor > 0.5
    )


def ways(recording: Recording, segments: Sequence[Segment], means: SegmentMeans) -> list[float]:
    """From each rest to the next, how far the gyros turned over the angle that gravity turned by,
    where it turned; no way is shorter than that angle.
    """
    imu = recording.imu
    order = np.argsort([s.t_start for s in segments])
    usable = (
        means.static & np.isfinite(means.gyro).all(axis=1) & np.isfinite(means.accel).all(axis=1)
    )
    rests = [int(k) for k in order if usable[k]]
    if len(rests) <= FEWEST_SEGMENTS:
        return []
    rate = np.nan_to_num(imu.stack(GYRO) - np.median(means.gyro[rests], axis=0))
    speed = np.linalg.norm(rate, axis=1)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(imu.t))])
    directions, ratios = directions_of(means.accel), list[float]()
    for a, b in pairwise(rests):
        angle = np.arccos(np.clip(directions[a] @ directions[b], -1.0, 1.0))
        if angle > TURNED:
            ends = (segments[a].t_end, segments[b].t_start)
            ratios.append(float(np.diff(np.interp(ends, imu.t, way))[0] / angle))
    return ratios


# Rates and forces in another unit than rad/s and m/s².

GAINS = (0.2, 5.0)  # of a gyro: what is nearer is a range or a scale factor
FORCES = (0.5, 1.5)  # of gravity at rest: what is nearer is a scale factor or a bias
REMOVED = 0.07  # of gravity at rest: biases alone
LEAST_WAYS = 20.0  # times the angle between rests that no unit is turned from one to the other
RIGHT_WAY = 0.5  # times that angle: gyros that read less than it do not read rad/s
DIRECT = 4.0  # times the most direct way: a way as people turn units
RATES = (
    (1.0, "rad/s"), (DEG, "deg/s"), (1e-3 * DEG, "mdps"), (1e-3, "mrad/s"), (DEG / 3600.0, "deg/h"),
    (DEG / 131.0, "131/dps"), (DEG / 65.5, "65.5/dps"), (DEG / 32.8, "32.8/dps"),
    (DEG / 16.4, "16.4/dps"), (1.0 / DEG, "57.2958rad/s"), (16.4, "16.4rad/s"),
    (32.8, "32.8rad/s"), (65.5, "65.5rad/s"), (131.0, "131rad/s"),
)  # fmt: skip
FINE = ("mg", "mdps", "deg/h")  # units so small that whole numbers of them are written
WHOLE_NUMBER = 1e-6  # by which numbers that are whole may be off, for they were kept in SI
MOST_RESTS = 0.9  # of the rests that agree on the size of gravity
AXES_ALIKE = 0.03  # of a factor, by which the axes of one setting may differ
LATTICE_ROWS = slice(0, 20_000)  # that show how numbers were written
COUNTS_PER_G = (16384.0, 8192.0, 4096.0, 2048.0)  # counts per g of usual accelerometers


def wrong_forces(recording: Recording, means: SegmentMeans, scale: float) -> Remark | None:
    """What the accelerometers read at rest that is not gravity in m/s²."""
    own = means.accel[means.static]
    own = own[np.isfinite(own).all(axis=1)]
    sizes = np.linalg.norm(own, axis=1)
    gravity = gravity_of(recording)
    if len(sizes) < FEWEST_SEGMENTS or not sizes.any():
        return None
    size = float(np.median(sizes))
    off = np.abs(np.log(np.maximum(sizes, 1e-12) / size))
    shown = {"read": f"{size:.4g}" if size >= 1 else f"{size:.2g}", "gravity": f"{gravity:.4f}",
             "ratio": f"{size / gravity:.4g}"}  # fmt: skip
    if FORCES[0] < size / gravity < FORCES[1]:
        axes = len(np.unique(np.abs(own).argmax(axis=1)))
        if abs(np.log(size / gravity)) < NEAR_FACTOR or off.max() > AXES_ALIKE or axes < 2:
            return None
        return found_on_sight(
            "force_setting", message("plausibility-force-setting", **shown), run="remarks"
        )
    if size < REMOVED * gravity:
        return found_on_sight(
            "gravity_removed", message("plausibility-gravity-removed", read=shown["read"])
        )
    factor = scale * gravity / size  # m/s² that one as it was written is
    usual = [(1.0, "m/s2"), (STANDARD_GRAVITY, "g"), (1e-3 * STANDARD_GRAVITY, "mg"),
             (0.3048, "ft/s2"),
             *((STANDARD_GRAVITY / n, f"{n:.0f}/g") for n in COUNTS_PER_G)]  # fmt: skip
    unit = None
    if np.quantile(off, MOST_RESTS) < NEAR_FACTOR:
        unit = _unit(factor, usual, recording.imu.stack(ACCEL, LATTICE_ROWS) / scale)
    return found_on_sight("force_unit", _unit_sentence("force", "accel", unit, shown))


def _unit_sentence(
    what: str, triad: str, unit: tuple[str, float] | None, shown: Mapping[str, str]
) -> Message:
    """What was read, and the unit that it looks like; or no advice where it looks like none."""
    name, off = unit or ("-", 0.0)
    option = f"--units {triad}={name}" if unit else ""
    return message(f"plausibility-{what}-unit", **shown, unit=name, off=f"{100.0 * off:.1f}",
                   advised="yes" if unit else "no", option=option)  # fmt: skip


def _unit(
    factor: float, usual: Sequence[tuple[float, str]], written: np.ndarray
) -> tuple[str, float] | None:
    """The usual unit of a factor to SI and how far (relative) the factor is from it, where the
    numbers (n, 3) as they were written are such as that unit's: counts are whole, and units as
    large as g are not. Else None.
    """
    size, name = min(usual, key=lambda one: abs(np.log(factor / one[0])))
    off = abs(factor / size - 1.0)
    numbers = written[np.isfinite(written)]
    is_whole = bool(np.abs(numbers - np.rint(numbers)).max(initial=0.0) < WHOLE_NUMBER)
    of_counts = name.partition("/")[0].replace(".", "").isdecimal()
    is_such = is_whole if of_counts else name in FINE or not is_whole
    return (name, float(off)) if abs(np.log(factor / size)) < NEAR_FACTOR and is_such else None


def wrong_table(
    recording: Recording, means: SegmentMeans, between_rests: Callable[[], list[float]]
) -> Remark | None:
    """Encoders in degrees: they turn so much farther than gyros which labels, or else gravity, show
    to be right.

    between_rests: how far gyros turn over the angles that gravity turns by.
    """
    ratio = turned_ratio(recording)
    if ratio is None or not 1.0 / AS_FAR < ratio / DEG < AS_FAR:
        return None
    labelled = [abs(s.rate_deg_s) for s in recording.manifest.segments or () if s.rate_deg_s]
    if labelled:
        fastest = np.nanmax(np.linalg.norm(means.gyro, axis=1)) / (DEG * max(labelled))
        is_right = GAINS[0] < fastest < GAINS[1]
    else:
        way = between_rests()
        is_right = len(way) > FEWEST_SEGMENTS and RIGHT_WAY < min(way) < LEAST_WAYS
    option = "--units table=deg"
    sentence = message("plausibility-table-unit", ratio=ratio_text(1.0 / ratio), option=option)
    return found_on_sight("table_unit", sentence) if is_right else None


def wrong_labels(segments: Sequence[Segment], means: SegmentMeans) -> Remark | None:
    """Labels of rates that gyros read as if they, or the gyros, were in the other of rad and °."""
    stated = {
        k: abs(means.gyro[k, AXES.index(s.axis)]) / (DEG * abs(s.rate_deg_s))
        for k, s in enumerate(segments)
        if s.kind == "rate" and s.axis and s.rate_deg_s and np.isfinite(means.gyro[k]).all()
    }
    for factor in (DEG, 1.0 / DEG):
        off = [k for k, ratio in stated.items() if abs(ratio / factor - 1.0) < NEAR_FACTOR]
        if len(off) > 0.5 * len(stated):
            names, label = tuple(segments[k].name for k in off), segments[off[0]].rate_deg_s or 0.0
            sentence = message(
                "plausibility-label-unit", count=len(off), segment=names[0], label=f"{label:g}",
                read=f"{abs(label) * stated[off[0]]:.4g}",
            )  # fmt: skip
            return found_on_sight("label_unit", sentence, names)
    return None


def wrong_rates(
    recording: Recording, sizes: np.ndarray, by_rate: np.ndarray, scale: float, source: str
) -> Remark | None:
    """A factor of the gyros' that no scale factor is.

    sizes: (r,) of their responses to the inputs; by_rate: (k,) to each rate alone: of a range that
    is too small they differ. source: of the rates that these are: labels, table or pose.
    """
    common = common_factor(sizes)
    if common is None or abs(np.log(common)) < NEAR_FACTOR:
        return None
    if GAINS[0] < common < GAINS[1]:
        every = np.concatenate([sizes, by_rate])
        if len(sizes) < 2 or np.abs(np.log(np.maximum(every, 1e-9) / common)).max() > AXES_ALIKE:
            return None
        sentence = message("plausibility-rate-setting", ratio=f"{common:.3f}", source=source)
        return found_on_sight("rate_setting", sentence, run="remarks")
    unit = _unit(scale / common, RATES, recording.imu.stack(GYRO, LATTICE_ROWS) / scale)
    shown = {"ratio": ratio_text(common), "source": source}
    if unit and recording.imu.span:  # of rates that were made of angles
        sentence = _unit_sentence("rate", "angle", (unit[0].removesuffix("/s"), unit[1]), shown)
    else:
        sentence = _unit_sentence("rate", "gyro", unit, shown)
    return found_on_sight("rate_unit", sentence)


def wrong_rates_by_ways(
    recording: Recording, ratios: Sequence[float], scale: float
) -> Remark | None:
    """A usual wrong unit of gyros that nothing but gravity says anything of."""
    ratio = min(ratios, default=0.0)
    direct = [one for one in ratios if one < DIRECT * ratio]
    if ratio < LEAST_WAYS or len(direct) <= FEWEST_SEGMENTS:
        return None
    unit = _unit(scale / ratio, RATES, recording.imu.stack(GYRO, LATTICE_ROWS) / scale)
    shown = {"ratio": ratio_text(ratio), "source": "gravity"}
    return unit and found_on_sight("rate_unit", _unit_sentence("rate", "gyro", unit, shown))


# Axes exchanged, inverted or turned as a whole, and columns of another sensor.

ASLANT = np.radians(10.0)  # from the nearest axes: a label that says an axis is up is wrong
ROTATION = 0.15  # by which the matrix of a unit that is turned may be none
SAME_TURN = np.radians(8.0)  # between the turns that both triads show
OF_FORCE = 0.2  # rad/s to either side, as gravity points: no gyro, which has 0.05 at the worst
FOLLOWS = 0.95  # of the variance of a column, which gravity explains
UNEXPLAINED_SHARE = 0.2  # of what is read of the other inputs


def turned_aslant(gyro: TriadMatrix | None, accel: TriadMatrix | None) -> Remark | None:
    """A unit that is turned against the labels' axes by an angle that no exchange of axes is."""
    turns = [turn for one in (gyro, accel) if one is not None and (turn := _turn(one)) is not None]
    known = [one for one in (gyro, accel) if one is not None]
    if not turns or len(turns) < len(known):
        return None
    turn = turns[0]
    if len(turns) == 2 and _angle(turns[0].T @ turns[1]) > SAME_TURN:
        return None
    proper = [matrix for matrix in MATRICES if np.linalg.det(matrix) > 0]
    if min(_angle(matrix.T @ turn) for matrix in proper) < ASLANT:
        return None
    about = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    about = about / max(float(np.linalg.norm(about)), 1e-9)
    axis = ", ".join(f"{one:+.2f}" for one in about).replace("-", "−")
    degrees = f"{np.degrees(_angle(turn)):.1f}"
    return found_on_sight("mount", message("plausibility-mount", degrees=degrees, axis=axis))


def _turn(found: TriadMatrix) -> np.ndarray | None:
    """The rotation (3, 3) by which a triad reads its inputs; None where it is none, or where fewer
    than two inputs tell it.
    """
    if found.directions.shape[1] < 2:
        return None
    left, sizes, right = np.linalg.svd(found.reads @ found.directions.T)
    known = sizes[: found.directions.shape[1]]
    if np.abs(np.log(np.maximum(known, 1e-9) / known.mean())).max() > ROTATION:
        return None
    if found.directions.shape[1] == 2:
        right[2] *= np.linalg.det(left) * np.linalg.det(right)
    turn = np.asarray(left @ right)
    return turn if np.linalg.det(turn) > 0 else None


def _angle(turn: np.ndarray) -> float:
    return float(np.arccos(np.clip(0.5 * (np.trace(turn) - 1.0), -1.0, 1.0)))


def columns_of_others(means: SegmentMeans, gyro: TriadMatrix | None) -> Remark | None:
    """Columns that are not what they are called: a gyro's that follows gravity, or a triad that
    reads nothing of one of its inputs.
    """
    rests = means.static & np.isfinite(means.up).all(axis=1)
    force = matrix_by_segments(means.accel[rests], means.up[rests], 0.1, forces=False)
    wrong = [message("plausibility-column-follows", channel=GYRO[c]) for c in _forces(means, rests)]
    for triad, found in (("gyro", gyro), ("accel", force)):
        if found is None or found.directions.shape[1] < len(AXES):
            continue
        sizes = np.linalg.norm(found.reads @ found.directions.T, axis=0)
        wrong += [
            message("plausibility-column-nothing", triad=triad, axis=AXES[k])
            for k in np.flatnonzero(sizes < UNEXPLAINED_SHARE * np.median(sizes))
        ]
    if not wrong:
        return None
    return found_on_sight("column_exchanged", message("plausibility-columns", what=tuple(wrong)))


def _forces(means: SegmentMeans, rests: np.ndarray) -> list[int]:
    """The gyros that follow gravity at rest."""
    gyro, up = means.gyro[rests], means.up[rests]
    columns = np.column_stack([np.ones(len(up)), up])
    if len(up) <= columns.shape[1] or not np.isfinite(gyro).all():
        return []
    found = np.linalg.lstsq(columns, gyro, rcond=None)[0]
    left, whole = (gyro - columns @ found).var(axis=0), gyro.var(axis=0)
    size = np.linalg.norm(found[1:], axis=0)
    return np.flatnonzero((size > OF_FORCE) & (left < (1.0 - FOLLOWS) * whole)).tolist()


def wrong_axes(gyro: TriadMatrix | None, accel: TriadMatrix | None) -> Remark | None:
    """Axes exchanged or inverted in one triad, or alike in both."""
    choices = [None if one is None else fitting(one) for one in (gyro, accel)]
    wrong = [k for k, good in enumerate(choices) if good and not _is_identity(good[0])]
    if not wrong:
        return None
    known = [k for k, good in enumerate(choices) if good]
    chosen = {k: choices[k][0] for k in wrong}  # type: ignore[index]
    both = len(known) == 2 and len(wrong) == 2
    if both:
        alike = [m for m in choices[0] or () if any(np.array_equal(m, n) for n in choices[1] or ())]
        both = bool(alike)
        chosen = dict.fromkeys(wrong, alike[0]) if both else chosen
    # Of a turn that one triad shows and the other says nothing of, the unit as it lay is the cause.
    both = both or (len(known) == 1 and np.linalg.det(chosen[wrong[0]]) > 0.0)
    entries, reads = list[str](), list[Message]()
    for k in wrong[:1] if both else wrong:
        name = "" if both else ("gyro_", "accel_")[k]
        matrix = chosen[k]
        entries += _entries(matrix.T, name)
        reads.append(_reads(matrix, "both" if both else ("gyro", "accel")[k]))
    option = f"--axes {','.join(entries)}"
    value = _response((gyro, accel)[wrong[0]], chosen[wrong[0]])
    return found_on_sight(
        "axes", message("plausibility-axes", reads=tuple(reads), value=value, option=option)
    )


def _is_identity(matrix: np.ndarray) -> bool:
    return bool(np.array_equal(matrix, np.eye(3)))


def _entries(matrix: np.ndarray, name: str) -> list[str]:
    """NEW=OLD of a signed permutation that puts readings in their places."""
    made = []
    for row, axis in enumerate(AXES):
        source = int(np.abs(matrix[row]).argmax())
        if matrix[row, row] != 1.0:
            sign = "-" if matrix[row, source] < 0 else ""
            made.append(f"{name}{axis}={sign}{name}{AXES[source]}")
    return made


def _reads(matrix: np.ndarray, triad: str) -> Message:
    """What a triad does: axes inverted, two exchanged, turned as a whole, or a mirror image."""
    moved = [k for k in range(3) if matrix[k, k] == 0.0]
    inverted = [k for k in range(3) if matrix[k, k] == -1.0]
    listed = ", ".join(
        f"{AXES[k]}: {'−' if matrix[k].sum() < 0 else '+'}{AXES[int(np.abs(matrix[k]).argmax())]}"
        for k in range(3) if matrix[k, k] != 1.0
    )  # fmt: skip
    if not moved and len(inverted) != 2:
        kind, names = "inverted", [AXES[k] for k in inverted]
    elif len(moved) == 2 and not inverted and matrix[moved].sum() == 2.0:
        kind, names = "exchanged", [AXES[k] for k in moved]
    else:
        kind = "turned" if np.linalg.det(matrix) > 0 else "mirrored"
        names = []
    return message(
        f"plausibility-{kind}", triad=triad, axes=", ".join(names) or "-",
        map=listed,
    )  # fmt: skip


def _response(found: TriadMatrix | None, matrix: np.ndarray) -> str:
    """What is read of the first input that is not read along its axis, as `zz = −1.003`."""
    assert found is not None
    full = found.reads @ found.directions.T
    wrong = [(r, int(np.abs(matrix[r]).argmax())) for r in range(3) if matrix[r, r] != 1.0]
    row, column = max(wrong, key=lambda place: abs(full[place]))
    return f"{AXES[row]}{AXES[column]} = {full[row, column]:.3f}".replace("-", "−")


# By how much all labels of a recording are late or early.
#
# The rows themselves say which of them a label could mean: at rest with its axis up, or turning
# at its rate. Where a good part of the rows contradicts the labels as they stand, and next to
# none contradicts them once they are all moved by the same time, that time is what they are
# shifted by.

BLOCK = 0.05  # s of a mean
EDGE = 0.25  # s, or a tenth of a label: what is looked at first
MOVING = np.radians(2.0)  # rad/s from rest, by which noise of a block and drift are no motion
UPRIGHT = 0.8  # cosine between what is read at rest and the axis up
NEARLY = 0.2  # of a rate, by which a gyro may read another
REACH = 120.0  # s
STEP = 0.05  # s
LEAST_COST, LEFT = 0.004, 0.02  # share of rows against the labels: as they stand, and moved
EQUAL_COSTS = 0.001  # share of rows by which costs are alike
BETTER = 0.15  # of the rows against them that a shift may leave
SMALLEST = 0.35  # s: streams may be offset from each other by a little
LEAST_SHIFT_ROWS = 2.0  # intervals of the unit's rows that a shift is at least
FEWEST_LABELS = 3  # labels


@dataclass(frozen=True)
class LabelShift:
    """seconds: to be added to all label times; within: half of the span that fits as well, s."""

    seconds: float
    within: float


def shift_of_labels(
    recording: Recording, gain: float = 1.0, zero: np.ndarray | None = None
) -> LabelShift | None:
    """The shift of all labels, or None where none is clear.

    gain: what the gyros read of a rate, where that is known to be no scale factor. zero: (3,) what
    they read at rest, where other labels than these tell it.
    """
    labels = _telling(recording)
    if len(labels) < FEWEST_LABELS or _fit_at_both_ends(recording, labels, gain):
        return None
    cost = _cost(recording, labels, gain, zero)
    if cost is None:
        return None
    as_stated = float(cost(np.zeros(1))[0])
    if as_stated < LEAST_COST:
        return None
    t = recording.imu.t
    reach = min(REACH, 0.5 * float(t[-1] - t[0]))
    least = max(SMALLEST, LEAST_SHIFT_ROWS * float(np.median(np.diff(t))))
    return _best(np.arange(-reach, reach + STEP, STEP), cost, as_stated, least)


def share_against(recording: Recording, zero: np.ndarray | None) -> float | None:
    """Which share of the rows contradicts the labels as they stand; None where few can tell."""
    labels = _telling(recording)
    cost = _cost(recording, labels, 1.0, zero) if len(labels) >= FEWEST_LABELS else None
    return None if cost is None else float(cost(np.zeros(1))[0])


def _telling(recording: Recording) -> list[Segment]:
    labels = [s for s in recording.manifest.segments or () if s.kind in ("static", "rate")]
    return [s for s in labels if s.kind == "static" or (s.axis and s.rate_deg_s)]


def _cost(
    recording: Recording, labels: list[Segment], gain: float, zero: np.ndarray | None
) -> Callable[[np.ndarray], np.ndarray] | None:
    """The share of rows against the labels, by shifts (k,) s of all of them."""
    t, gyro, accel = _blocks(recording, zero)
    if len(t) < 2 or not np.isfinite(gyro).all(axis=1).mean() > 0.5:
        return None
    gyro = gyro / gain
    fits = [_fits(label, gyro, accel) for label in labels]
    span = np.array([(s.t_start, s.t_end) for s in labels])
    weight = np.diff(span, axis=1)[:, 0]
    counts = [np.concatenate([[0], np.cumsum(~one)]) for one in fits]
    interval = max(float(np.median(np.diff(t))), 1e-9)

    def cost(shift: np.ndarray) -> np.ndarray:
        against = np.zeros(len(shift))
        for (start, end), wrong, w in zip(span, counts, weight, strict=True):
            first = np.searchsorted(t, start + shift)
            last = np.maximum(np.searchsorted(t, end + shift), first)
            rows = last - first
            expected = w / interval
            missing = np.maximum(expected - rows - 1.0, 0.0)  # beyond the recording: against it
            against += w * (wrong[last] - wrong[first] + missing) / np.maximum(expected, 1.0)
        return np.asarray(against / weight.sum())

    return cost


def _best(
    shifts: np.ndarray,
    cost: Callable[[np.ndarray], np.ndarray],
    as_stated: float,
    least: float,
) -> LabelShift | None:
    """The shift of at least `least` s that leaves next to nothing against the labels, where it
    stands alone.
    """
    costs = cost(shifts)
    best = int(costs.argmin())
    good = costs <= costs[best] + EQUAL_COSTS
    low, high = best, best
    while low > 0 and good[low - 1]:
        low -= 1
    while high + 1 < len(good) and good[high + 1]:
        high += 1
    seconds, within = 0.5 * (shifts[low] + shifts[high]), 0.5 * (shifts[high] - shifts[low])
    elsewhere = np.concatenate([costs[: max(low - 20, 0)], costs[high + 20 :]])
    is_clear = (
        costs[best] <= min(LEFT, BETTER * as_stated)
        and abs(seconds) >= max(least, within)
        and elsewhere.min(initial=1.0) >= 2.0 * costs[best] + 0.01
    )
    return LabelShift(float(seconds), float(within)) if is_clear else None


def _fit_at_both_ends(recording: Recording, labels: list[Segment], gain: float) -> bool:
    """Whether what is read as every label begins and ends is what it says: then none is shifted."""
    ends, own = list[slice](), list[Segment]()
    for label in labels:
        edge = min(EDGE, 0.1 * (label.t_end - label.t_start))
        ends += [recording.imu.rows(label.t_start, label.t_start + edge),
                 recording.imu.rows(label.t_end - edge, label.t_end)]  # fmt: skip
        own += [label, label]
    read = (recording.imu.channels(GYRO + ACCEL, rows) for rows in ends)
    means = np.array([one.mean(axis=1) if one.size else np.full(6, np.nan) for one in read])
    at_rest = np.array([label.kind == "static" for label in own])
    gyro = _from_rest(means[:, :3], at_rest) / gain
    direction = directions_of(means[:, 3:])
    fits = [_fits(label, gyro[k, None], direction[k, None])[0] for k, label in enumerate(own)]
    return all(fits)


def _from_rest(gyro: np.ndarray, at_rest: np.ndarray) -> np.ndarray:
    """Rates (m, 3) from what is usual at rest; of a triad that was not recorded NaN."""
    usual = gyro[at_rest & np.isfinite(gyro).all(axis=1)]
    return gyro - np.median(usual, axis=0) if len(usual) else gyro


def _blocks(
    recording: Recording, zero: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, rates from rest and directions of force (m, 3), as means over BLOCK."""
    imu = recording.imu
    interval = float(np.median(np.diff(imu.t)))
    rows = max(1, round(BLOCK / max(interval, 1e-9)))
    means = in_blocks(np.column_stack([imu.t, imu.stack(GYRO), imu.stack(ACCEL)]), rows).mean(
        axis=1
    )
    t, gyro, accel = means[:, 0], means[:, 1:4], means[:, 4:]
    at_rest = np.zeros(len(t), bool)
    for label in recording.manifest.segments or ():
        if label.kind == "static":
            at_rest |= (t >= label.t_start) & (t < label.t_end)
    rate = _from_rest(gyro, at_rest) if zero is None else gyro - zero
    return t, rate, directions_of(accel)


def _fits(label: Segment, gyro: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """(m,) bool: which rows a label could mean."""
    if label.kind == "static":
        fits = np.linalg.norm(gyro, axis=1) < MOVING
        up = unit_vector(label.up)
        if np.isfinite(up).all() and np.isfinite(direction).all(axis=1).mean() > 0.5:
            fits &= direction @ up > UPRIGHT
        return np.asarray(fits)
    assert label.axis is not None
    rate = np.radians(label.rate_deg_s or 0.0)
    read = gyro[:, AXES.index(label.axis)]
    return np.asarray(np.abs(read - rate) < NEARLY * abs(rate) + MOVING)


# Readings that stand still: channels that are held while the unit moves, and steps of an output
# that are wider than its noise.

CHANNELS = GYRO + ACCEL
STUCK_SECONDS = 2.0
FEWEST_STANDING_ROWS = 20  # rows that stand
LATER = 8  # rows: what repeats as often after so many is coarse, and not held
PARTS, PART_ROWS = 4, 1000  # parts of a segment that are looked at, and rows of each
HELD = 0.05  # of the rows of a segment, beyond what is usual in those of its kind
BEYOND = 3.0  # times what is usual there
BY_CHANCE = 6.0  # standard deviations of such a share
FEW_ROWS = 100  # of a segment: too few to tell
STEP_ROWS = 8000  # rows that a step is looked for in
FEW_ALIKE = 3  # segments of a kind that show what is usual


def longest_repeat(values: np.ndarray) -> tuple[int, int]:
    """First row and length of the longest run of one value in (n,)."""
    changes = np.flatnonzero(np.diff(values)) + 1
    edges = np.concatenate(([0], changes, [len(values)]))
    lengths = np.diff(edges)
    longest = int(lengths.argmax())
    return int(edges[longest]), int(lengths[longest])


def longest_run(flags: np.ndarray) -> int:
    """Length of the longest run of True in (n,) flags."""
    return int(np.diff(runs(flags), axis=1).max(initial=0))


def runs(flags: np.ndarray) -> np.ndarray:
    """First row of each run of True in (n,) flags, and the row after its last; (runs, 2)."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0]))))
    return edges.reshape(-1, 2)


def standing(recording: Recording, segment: Segment) -> Iterator[tuple[int, int, int]]:
    """The channels that stand at one value for long in a segment, with the first row of the
    recording and the number of rows."""
    place = recording.imu.rows(segment.t_start, segment.t_end)
    rows = place.stop - place.start
    if segment.kind == "rotation" or rows < 2:
        return
    t = recording.imu.t[place]
    interval = float(t[-1] - t[0]) / (rows - 1)
    shortest = min(max(FEWEST_STANDING_ROWS, round(STUCK_SECONDS / interval)), rows)
    views = recording.imu.views(CHANNELS, place)
    # A run of `shortest` rows holds two neighbours of a sample that takes every half of it.
    sample = np.array([values[:: max(1, shortest // 2)] for values in views])
    repeats = (sample[:, 1:] == sample[:, :-1]).any(axis=1) | (sample.shape[1] == 1)
    for channel in np.flatnonzero(repeats).tolist():
        start, length = longest_repeat(views[channel])
        if length >= shortest:
            yield channel, place.start + start, length


def coarse_where_it_moves(recording: Recording, segments: Sequence[Segment]) -> np.ndarray:
    """Channels (6,) whose step is wider than their noise in most segments in which they move; of
    one that moves in none, whether it stands at different values.
    """
    imu = recording.imu
    places = [imu.rows(s.t_start, s.t_end) for s in segments if s.kind != "rotation"]
    parts = [
        imu.channels(CHANNELS, slice(place.start, min(place.stop, place.start + PART_ROWS)))
        for place in places
        if place.stop - place.start > 1
    ]
    if not parts:
        return np.zeros(len(CHANNELS), bool)
    step = steps(imu)
    deviation = np.array([part.std(axis=1) for part in parts])
    moves = deviation > 1e-6 * step
    hidden = (deviation < step / np.sqrt(3.0)) & moves  # Sheppard: noise of less than half a step
    stands = [len(set(one)) > 1 for one in np.array([part[:, 0] for part in parts]).T.tolist()]
    most = hidden.sum(axis=0) > 0.5 * moves.sum(axis=0)
    return np.asarray(np.where(moves.any(axis=0), most, stands))


def coarse_remarks(recording: Recording, segments: Sequence[Segment]) -> Iterator[Remark]:
    """One remark for a triad whose channels stand at one code, for they are logged coarsely."""
    stood = {s.name: {c for c, _, _ in standing(recording, s)} for s in segments}
    if not any(stood.values()):
        return
    coarse = coarse_where_it_moves(recording, segments)
    step = steps(recording.imu)
    for k, triad in enumerate(TRIADS):
        own = {c for c in range(3 * k, 3 * k + 3) if coarse[c]}
        names = tuple(name for name, channels in stood.items() if channels & own)
        if names:
            count = sum(len(channels & own) for channels in stood.values())
            yield found_on_sight(
                "coarse_log",
                message("plausibility-coarse-log", sensors=triad[0][:-2], count=count,
                        segments=len(names), of=len(segments), step=plain(max(step[list(own)]), 3)),
                names, run="remarks",
            )  # fmt: skip


def held_remarks(recording: Recording, segments: Sequence[Segment]) -> Iterator[Remark]:
    """Segments in which rows repeat the row before far more often than in others of their kind.

    What is logged faster than it is read repeats rows in all of them; what is coarse repeats them
    as often a few rows later.
    """
    for still in (True, False):
        own, of_own = list[Segment](), list[tuple[int, np.ndarray, np.ndarray]]()
        for segment in (s for s in segments if (s.kind == "static") == still):
            part = _parts(recording, segment)
            if part.shape[1] >= FEW_ROWS:
                own.append(segment)
                of_own.append((part.shape[1], _again(part, 1), _again(part, LATER)))
        if len(own) <= FEW_ALIKE:
            continue
        rows, shares, later = map(np.array, zip(*of_own, strict=True))
        beyond = shares - later
        usual = np.maximum(median(np.abs(beyond).T), 0.0)
        chance = BY_CHANCE * np.sqrt(2.0 * shares * (1.0 - shares) / rows[:, None])
        held = beyond > np.maximum(HELD, chance) + BEYOND * usual
        for k, triad in enumerate(TRIADS):
            mine = held[:, 3 * k : 3 * k + 3]
            names = tuple(own[i].name for i in np.flatnonzero(mine.any(axis=1)))
            if names and len(names) < 0.5 * len(own):
                worst = float(shares[:, 3 * k : 3 * k + 3][mine].max())
                yield found_on_sight(
                    "held_rows",
                    message("plausibility-held-rows", sensors=triad[0][:-2], count=len(names),
                            listed=", ".join(names), share=plain(100.0 * worst, 2),
                            usual=plain(100.0 * float(np.median(shares[:, 3 * k : 3 * k + 3])), 2)),
                    names, run="remarks",
                )  # fmt: skip


def _parts(recording: Recording, segment: Segment) -> np.ndarray:
    """(6, n) of a segment's readings: all, or some stretches of it."""
    place = recording.imu.rows(segment.t_start, segment.t_end)
    rows = place.stop - place.start
    if rows <= PARTS * PART_ROWS:
        return recording.imu.channels(CHANNELS, place)
    starts = place.start + np.linspace(0, rows - PART_ROWS, PARTS).astype(int)
    taken = [recording.imu.channels(CHANNELS, slice(a, a + PART_ROWS)) for a in starts.tolist()]
    return np.hstack(taken)


def _again(values: np.ndarray, later: int) -> np.ndarray:
    """(c,) share of the readings of channels (c, n) that are those of so many rows before."""
    return np.asarray((values[:, later:] == values[:, :-later]).mean(axis=1))


def steps(imu: Stream) -> np.ndarray:
    """(6,) the smallest difference between two readings of each channel, 0 where all are one."""
    every = max(1, len(imu.t) // STEP_ROWS)
    smallest = np.zeros(len(CHANNELS))
    for channel, name in enumerate(CHANNELS):
        if name in imu.columns:
            sample = imu.columns[name][::every]
            sample = np.sort(sample[np.isfinite(sample)])  # rows without the triad say nothing
            apart = np.diff(sample)
            resolution = 8 * np.finfo(float).eps * np.abs(sample).max(initial=0.0)
            smallest[channel] = apart[apart > resolution].min(initial=np.inf)
    return np.where(np.isfinite(smallest), smallest, 0.0)


SEEN_IN_FILE = TypeAdapter(tuple[Seen, ...])


def on_sight(
    recording: Recording, segments: Sequence[Segment], read: np.ndarray | None = None
) -> tuple[Remark, ...]:
    """All that is found on sight, each in one remark: what the reader of its file saw, what it
    cannot be, and what stands in it that its segments show; nothing for a plausible one.

    segments: its labels, or what was found; read: (k, 6) means of all their rows, where each is
    measured and they are known.
    """
    used = [s for s in segments if s.kind in ("static", "rate", "rotation")]
    return (
        *_seen_in_file(recording),
        *_impossible(recording, used, read),
        *held_remarks(recording, used),
        *(() if gives_angles(recording) else coarse_remarks(recording, used)),
    )


def _seen_in_file(recording: Recording) -> Iterator[Remark]:
    imported = (recording.manifest.model_extra or {}).get("imported")
    kept = imported.get(SEEN, ()) if isinstance(imported, dict) else ()
    with suppress(ValidationError):  # of a file that another wrote
        for one in SEEN_IN_FILE.validate_python(kept):
            yield found_on_sight(one.code, one.message, one.segments, one.run)


def _impossible(
    recording: Recording, used: Sequence[Segment], read: np.ndarray | None
) -> tuple[Remark, ...]:
    """What the recording cannot be."""
    scales = _units_of_source(recording)
    tracked = attitude_stream(recording) is not None and recording.table is None
    if len(recording.imu) < 2:
        return ()
    means = segment_means(recording, used, read)
    if (wrong := wrong_time(recording, used, means)) is not None:
        return (wrong,)
    if tracked:
        return _beside_poses(recording, scales)
    if not used:
        return ()
    gyro = matrix_by_segments(means.gyro, means.rate, EXCITED[0], forces=False)
    still = means.static & np.isfinite(means.up).all(axis=1)
    direction, removed = directions_of(means.accel), wrong_forces(recording, means, scales[1])
    is_removed = removed is not None and removed.code == "gravity_removed"
    accel = None if is_removed else matrix_of_directions(direction[still], means.up[still])
    between_rests = partial(ways, recording, used, means)
    usual = _is_usual(gyro)
    wrong = wrong_labels(used, means) if usual or gyro is None else None
    if wrong is None and not usual:
        wrong = wrong_table(recording, means, between_rests)
    if wrong is not None:
        return (wrong,)
    source = "labels" if recording.table is None else "table"
    rates = wrong_rates(recording, responses(gyro), sizes_by_rates(means), scales[0], source)
    if gyro is None and not (means.rate[~means.static] != 0.0).any():
        rates = wrong_rates_by_ways(recording, between_rests(), scales[0])
    shifted = _shift(recording, gyro) if recording.manifest.segments else None
    mapped = None
    if shifted is None:
        mapped = turned_aslant(gyro, accel) or wrong_axes(gyro, accel)
        mapped = mapped or columns_of_others(means, gyro)
    return tuple(one for one in (removed, rates, shifted, mapped) if one is not None)


def _beside_poses(recording: Recording, scales: tuple[float, float]) -> tuple[Remark, ...]:
    """The rates of a tracked body's unit, which may be turned against it in any way."""
    wrong = wrong_rates(recording, sizes_beside_poses(recording), np.zeros(0), scales[0], "pose")
    return () if wrong is None else (wrong,)


def _units_of_source(recording: Recording) -> tuple[float, float]:
    """rad/s and m/s² that one is of the units that the readings were imported from."""
    imported = (recording.manifest.model_extra or {}).get("imported")
    factors = imported.get(SI_PER_UNIT) if isinstance(imported, dict) else None
    if not isinstance(factors, dict):
        return 1.0, 1.0
    gyro, accel = (factors.get(triad, 1.0) for triad in ("gyro", "accel"))
    is_known = all(isinstance(one, int | float) and one > 0.0 for one in (gyro, accel))
    return (float(gyro), float(accel)) if is_known else (1.0, 1.0)


def _is_usual(gyro: TriadMatrix | None) -> bool:
    """Whether gyros read what the encoders or labels show, but for a range or a scale factor."""
    common = common_factor(responses(gyro))
    return common is not None and GAINS[0] < common < GAINS[1]


def _shift(recording: Recording, gyro: TriadMatrix | None) -> Remark | None:
    common = common_factor(responses(gyro))
    found = shift_of_labels(recording, 1.0 if common is None or _is_usual(gyro) else common)
    if found is None:
        return None
    late = found.seconds < 0
    option = f"--shift {found.seconds:.2f}"
    return found_on_sight(
        "labels_shifted",
        message("plausibility-labels-shifted", seconds=f"{abs(found.seconds):.2f}",
                within=f"{found.within:.2f}", late="late" if late else "early", option=option),
    )  # fmt: skip
