"""What a recording cannot be: wrong units, axes and clocks, each told in one sentence.

By the means of the segments beside what the unit went through there, from encoders or from labels:
a matrix of what is read of each input, as a signed permutation times a factor. Only what fits a
usual mistake, and leaves next to nothing of the readings, is named; anything else is left to those
who search. Labels that are shifted as a whole are found by the rows that contradict them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from schemas.recording import ACCEL, AXES, GYRO, Recording, Segment
from tasks.motion.table import mean_rate, mount_of, table_vectors
from tasks.motion.whole import STANDARD_GRAVITY, attitude_stream, gravity_of, unit_vector
from tasks.readings.axes import EXCITED, TriadMatrix, fitting, matrix_of
from tasks.readings.label_shift import shift_of_labels
from tasks.words import Message, message

KINDS = ("time_unit", "gravity_removed", "force_unit", "rate_unit", "table_unit", "axes",
         "labels_shifted")  # fmt: skip
DEG = np.pi / 180.0
NEAR = 0.08  # of a usual factor: as near as working units are
AS_FAR = 2.5  # times: axes that turn together, noise
LEAST_WAYS = 20.0  # times the angle between rests that no unit is turned from one to the other
DIRECT = 4.0  # times the most direct way: a way as people turn units
GAINS = (0.2, 5.0)  # of a gyro: what is nearer is a range or a scale factor
FORCES = (0.5, 1.5)  # of gravity at rest: what is nearer is a scale factor or a bias
REMOVED = 0.07  # of gravity at rest: biases alone
SPARE = 2  # segments more than a matrix of rates needs: what they leave shows whether it fits
FEW = 2  # segments that tell a unit
SLOWEST = 0.25  # s between rows, from which the time may be in a smaller unit
FASTEST = 2e4  # Hz
TIMES = ((1e3, "ms"), (1e6, "us"), (1e9, "ns"))
TURNED = np.radians(30.0)  # between rests: a move
LONGEST_WAY = 100.0  # times the angle between two rests that a unit turns from one to the other
RATES = (
    (1.0, "rad/s"), (DEG, "deg/s"), (1e-3 * DEG, "mdps"), (1e-3, "mrad/s"), (DEG / 3600.0, "deg/h"),
    (DEG / 131.0, "131/dps"), (DEG / 65.5, "65.5/dps"), (DEG / 32.8, "32.8/dps"),
    (DEG / 16.4, "16.4/dps"), (1.0 / DEG, "57.2958rad/s"), (16.4, "16.4rad/s"),
    (32.8, "32.8rad/s"), (65.5, "65.5rad/s"), (131.0, "131rad/s"),
)  # fmt: skip
STEPS = (16384.0, 8192.0, 4096.0, 2048.0)  # counts per g of usual accelerometers


@dataclass(frozen=True)
class Implausible:
    """One thing that a recording cannot be.

    kind: its catalogue name. sentence: what is wrong, by how much and how to import it right.
    option: that of `mimucal import`, empty where none helps.
    """

    kind: str
    sentence: Message
    option: str = ""


@dataclass(frozen=True)
class SegmentMeans:
    """Of k segments: means of gyros and accelerometers (k, 3), rates and directions of up (k, 3)
    by encoders or else labels; NaN where not known. static: (k,) bool.
    """

    gyro: np.ndarray
    accel: np.ndarray
    rate: np.ndarray
    up: np.ndarray
    static: np.ndarray


def implausible(
    recording: Recording, segments: Sequence[Segment], scales: tuple[float, float] = (1.0, 1.0)
) -> tuple[Implausible, ...]:
    """What the recording cannot be, each in one sentence; nothing for a plausible one.

    segments: its labels, or what was found. scales: rad/s and m/s² that one of the units is in
    which the readings were written, so that the right unit can be named.
    """
    used = [s for s in segments if s.kind in ("static", "rate", "rotation")]
    if len(recording.imu) < 2:
        return ()
    means = segment_means(recording, used)
    if (wrong := _time(recording, used, means)) is not None:
        return (wrong,)
    if not used:
        return ()
    gyro = _matrix(means.gyro, means.rate, EXCITED[0], forces=False)
    still = means.static & np.isfinite(means.up).all(axis=1)
    direction, removed = _directions(means.accel), _forces(recording, means, scales[1])
    accel = None if removed and removed.kind == "gravity_removed" else _matrix(
        direction[still], means.up[still], 0.1, forces=True
    )  # fmt: skip
    tracked = attitude_stream(recording) is not None and recording.table is None
    rates = _rates(recording, used, gyro, scales[0])
    if gyro is None and not (means.rate[~means.static] != 0.0).any():
        rates = _rates_by_ways(ways(recording, used, means), scales[0])
    found = [removed, rates]
    shifted = _shift(recording, gyro) if recording.manifest.segments else None
    mapped = None if tracked or shifted is not None else _axes(gyro, accel)
    return tuple(one for one in (*found, shifted, mapped) if one is not None)


def segment_means(recording: Recording, segments: Sequence[Segment]) -> SegmentMeans:
    """Means and inputs of segments."""
    imu = recording.imu
    rows = [imu.rows(s.t_start, s.t_end) for s in segments]
    read = np.array([
        [values.mean() if len(values) else np.nan for values in imu.views(GYRO + ACCEL, place)]
        for place in rows
    ]).reshape(-1, 6)  # fmt: skip
    rates, ups = np.full((2, len(segments), 3), np.nan)
    for k, segment in enumerate(segments):
        by_table = mean_rate(recording, segment)
        rates[k] = _labelled_rate(segment) if by_table is None else by_table
        ups[k] = _up(recording, segment)
    static = np.array([s.kind == "static" for s in segments], bool)
    return SegmentMeans(read[:, :3], read[:, 3:], rates, ups, static)


def _labelled_rate(segment: Segment) -> np.ndarray:
    """(3,) rad/s; NaN where the label does not tell it."""
    if segment.kind == "static":
        return np.zeros(3)
    degrees = segment.rate_deg_s
    if segment.kind == "rotation":
        degrees = (segment.angle_deg or 0.0) / max(segment.t_end - segment.t_start, 1e-9)
    if segment.axis is None or degrees is None:
        return np.full(3, np.nan)
    return np.eye(3)[AXES.index(segment.axis)] * degrees * DEG


def _up(recording: Recording, segment: Segment) -> np.ndarray:
    """(3,) by the encoders at the middle of a rest, else by its label."""
    axes, table = recording.manifest.station.table_axes, recording.table
    if segment.kind != "static":
        return np.full(3, np.nan)
    if not axes or table is None:
        return unit_vector(segment.up)
    middle = 0.5 * (segment.t_start + segment.t_end)
    if not table.t[0] <= middle <= table.t[-1]:
        return np.full(3, np.nan)
    angle = [np.interp(middle, table.t, table.columns[f"{axis.name}_angle"]) for axis in axes]
    up = table_vectors(recording.manifest.station, np.array([angle]))[0][0]
    return np.asarray(up @ mount_of(recording.manifest, segment))


def _directions(accel: np.ndarray) -> np.ndarray:
    """Unit vectors (k, 3) along what the accelerometers read."""
    size = np.linalg.norm(accel, axis=1)[:, None]
    return np.where(size > 0, accel / np.where(size > 0, size, 1.0), np.nan)


def _matrix(
    read: np.ndarray, felt: np.ndarray, excited: float, *, forces: bool
) -> TriadMatrix | None:
    both = np.isfinite(read).all(axis=1) & np.isfinite(felt).all(axis=1)
    if both.sum() < FEW:
        return None
    found = matrix_of(read[both], felt[both], excited, forces=forces)
    if found is not None and not forces and both.sum() < found.reads.shape[1] + SPARE:
        return None
    return found


def _common(matrix: TriadMatrix) -> float | None:
    """The factor that all responses have in common; None where they differ."""
    sizes = np.linalg.svd(matrix.reads, compute_uv=False)
    if not sizes.min() > 0:
        return None
    common = float(np.exp(np.log(sizes).mean()))
    return common if np.abs(np.log(sizes / common)).max() < NEAR else None


# ---- time


def _time(
    recording: Recording, segments: Sequence[Segment], means: SegmentMeans
) -> Implausible | None:
    """Times in a smaller unit than s: by the rates of encoders, by the way between rests, or by
    labels and streams of which one lasts a thousand times as long.
    """
    t = recording.imu.t
    ends = {"imu": t[-1]} | {n: s.t[-1] for n, s in recording.streams().items() if n == "table"}
    ends |= {"labels": max(s.t_end for s in segments)} if segments else {}
    for other, end in ends.items():
        for factor, unit in TIMES:
            for long, short in ((other, "imu"), ("imu", other)):
                if abs(ends[long] / ends[short] / factor - 1.0) < 0.5 and long == "labels":
                    return _time_sentence("labels", end, factor, f"--units labels={unit}")
    interval = float(np.median(np.diff(t)))
    if interval < SLOWEST:
        return None
    for factor, unit in TIMES:
        if interval / factor > 1.0 / 4.0 or interval / factor < 1.0 / FASTEST:
            continue
        if _by_encoders(recording, factor) or _by_ways(recording, segments, means, factor):
            return _time_sentence("recording", interval, factor, f"--units t={unit}")
    return None


def _time_sentence(what: str, value: float, factor: float, option: str) -> Implausible:
    unit = option.rpartition("=")[2]
    return Implausible(
        "time_unit",
        message("plausibility-time", what=what, value=f"{value:.4g}", factor=f"{factor:.0f}",
                unit=unit, option=option),
        option,
    )  # fmt: skip


def _by_encoders(recording: Recording, factor: float) -> bool:
    """Whether gyros turn as far as encoders once their times are divided."""
    imu, table = recording.imu, recording.table
    gyro = imu.stack(GYRO)
    if table is None or not np.isfinite(gyro).all():
        return False
    angles = [v for name, v in table.columns.items() if name.endswith("_angle")]
    turned = sum(float(np.abs(np.diff(np.unwrap(angle))).sum()) for angle in angles)
    speed = np.linalg.norm(gyro - np.median(gyro, axis=0), axis=1)
    read = float(np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(imu.t)))
    return turned > np.pi and 1.0 / AS_FAR < read / turned / factor < AS_FAR


def _by_ways(
    recording: Recording, segments: Sequence[Segment], means: SegmentMeans, factor: float
) -> bool:
    """Whether between all rests the gyros turn by far too much for what gravity turned by, and
    once the times are divided by enough.
    """
    ratios = ways(recording, segments, means)
    return len(ratios) > FEW and min(ratios) > LONGEST_WAY and min(ratios) / factor > 0.5


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
    if len(rests) <= FEW:
        return []
    rate = np.nan_to_num(imu.stack(GYRO) - np.median(means.gyro[rests], axis=0))
    speed = np.linalg.norm(rate, axis=1)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(imu.t))])
    directions, ratios = _directions(means.accel), list[float]()
    for a, b in pairwise(rests):
        angle = np.arccos(np.clip(directions[a] @ directions[b], -1.0, 1.0))
        if angle > TURNED:
            ends = (segments[a].t_end, segments[b].t_start)
            ratios.append(float(np.diff(np.interp(ends, imu.t, way))[0] / angle))
    return ratios


# ---- units


def _forces(recording: Recording, means: SegmentMeans, scale: float) -> Implausible | None:
    """What the accelerometers read at rest that is not gravity in m/s²."""
    own = means.accel[means.static]
    sizes = np.linalg.norm(own[np.isfinite(own).all(axis=1)], axis=1)
    gravity = gravity_of(recording)
    if len(sizes) < FEW or not sizes.any():
        return None
    size = float(np.median(sizes))
    if FORCES[0] < size / gravity < FORCES[1]:
        return None
    read = f"{size:.4g}" if size >= 1 else f"{size:.2g}"
    if size < REMOVED * gravity:
        return Implausible("gravity_removed", message("plausibility-gravity-removed", read=read))
    factor = scale * gravity / size  # m/s² that one as it was written is
    usual = [(1.0, "m/s2"), (STANDARD_GRAVITY, "g"), (1e-3 * STANDARD_GRAVITY, "mg"),
             (0.3048, "ft/s2"),
             *((STANDARD_GRAVITY / n, f"{n:.0f}/g") for n in STEPS)]  # fmt: skip
    unit = _unit(factor, usual, "m/s2", NEAR)
    return Implausible(
        "force_unit",
        message("plausibility-force-unit", read=read, gravity=f"{gravity:.4f}",
                ratio=f"{size / gravity:.4g}", unit=unit, option=f"--units accel={unit}"),
        f"--units accel={unit}",
    )  # fmt: skip


def _unit(factor: float, usual: Sequence[tuple[float, str]], si: str, near: float) -> str:
    """The usual unit of a factor to SI, else the factor itself."""
    size, name = min(usual, key=lambda one: abs(np.log(factor / one[0])))
    return name if abs(np.log(factor / size)) < near else f"{factor:.5g}{si}"


def _rates(
    recording: Recording, segments: Sequence[Segment], gyro: TriadMatrix | None, scale: float
) -> Implausible | None:
    """A factor of the gyros' that no scale factor is."""
    common = None if gyro is None else _common(gyro)
    if common is None or GAINS[0] < common < GAINS[1]:
        return None
    labels = _label_ratio(recording, segments)
    source = "labels" if recording.table is None else "table"
    if recording.table is not None and labels is not None and abs(np.log(labels * common)) < NEAR:
        unit = _unit(common, ((DEG, "deg"), (1e-3, "mrad"), (1e-3 * DEG, "mdeg")), "rad", NEAR)
        option, kind, ratio = f"--units table={unit}", "table_unit", _ratio(1.0 / common)
    else:
        unit = _unit(scale / common, RATES, "rad/s", NEAR)
        option, kind, ratio = f"--units gyro={unit}", "rate_unit", _ratio(common)
    return Implausible(
        kind,
        message(
            f"plausibility-{kind.replace('_', '-')}", ratio=ratio, source=source, unit=unit,
            option=option,
        ),
        option,
    )  # fmt: skip


def _rates_by_ways(ratios: Sequence[float], scale: float) -> Implausible | None:
    """A usual wrong unit of gyros that nothing but gravity says anything of."""
    ratio = min(ratios, default=0.0)
    direct = [one for one in ratios if one < DIRECT * ratio]
    if ratio < LEAST_WAYS or len(direct) <= FEW:
        return None
    unit = _unit(scale / ratio, RATES, "", NEAR)
    if not any(unit == name for _, name in RATES):
        return None
    option = f"--units gyro={unit}"
    shown = _ratio(ratio)
    return Implausible(
        "rate_unit",
        message("plausibility-rate-unit", ratio=shown, source="gravity", unit=unit, option=option),
        option,
    )


def _ratio(value: float) -> str:
    return f"{value:.4g}" if value > 1 else f"1/{1.0 / value:.4g}"


def _label_ratio(recording: Recording, segments: Sequence[Segment]) -> float | None:
    """What the encoders turn at over what the labels say, in the median of the rates."""
    ratios = []
    for segment in segments:
        rate = mean_rate(recording, segment)
        if segment.kind == "rate" and segment.rate_deg_s and rate is not None:
            ratios.append(float(np.linalg.norm(rate)) / abs(segment.rate_deg_s * DEG))
    return float(np.median(ratios)) if ratios and np.median(ratios) > 0 else None


# ---- axes


def _axes(gyro: TriadMatrix | None, accel: TriadMatrix | None) -> Implausible | None:
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
    entries, reads = list[str](), list[Message]()
    for k in wrong[:1] if both else wrong:
        name = "" if both else ("gyro_", "accel_")[k]
        matrix = chosen[k]
        entries += _entries(matrix.T, name)
        reads.append(_reads(matrix, "both" if both else ("gyro", "accel")[k]))
    option = f"--axes {','.join(entries)}"
    value = _response((gyro, accel)[wrong[0]], chosen[wrong[0]])
    return Implausible(
        "axes", message("plausibility-axes", reads=tuple(reads), value=value, option=option), option
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
        f"plausibility-{kind}", triad=triad, axes=", ".join(names) or "-", count=len(names),
        map=listed,
    )  # fmt: skip


def _response(found: TriadMatrix | None, matrix: np.ndarray) -> str:
    """What is read of the first input that is not read along its axis, as `zz = −1.003`."""
    assert found is not None
    full = found.reads @ found.directions.T
    wrong = [(r, int(np.abs(matrix[r]).argmax())) for r in range(3) if matrix[r, r] != 1.0]
    row, column = max(wrong, key=lambda place: abs(full[place]))
    return f"{AXES[row]}{AXES[column]} = {full[row, column]:.3f}".replace("-", "−")


# ---- labels


def _shift(recording: Recording, gyro: TriadMatrix | None) -> Implausible | None:
    common = None if gyro is None else _common(gyro)
    usual = common is None or GAINS[0] < common < GAINS[1]
    found = shift_of_labels(recording, 1.0 if usual or common is None else common)
    if found is None:
        return None
    late = found.seconds < 0
    option = f"--shift {found.seconds:.2f}"
    return Implausible(
        "labels_shifted",
        message("plausibility-labels-shifted", seconds=f"{abs(found.seconds):.2f}",
                within=f"{found.within:.2f}", late="late" if late else "early", option=option),
        option,
    )  # fmt: skip
