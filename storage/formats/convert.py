"""A recording with other axes, units and label times, as the person who imports it says."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from schemas.base import Unusable
from schemas.recording import ACCEL, AXES, GYRO, Recording, Segment, Stream
from storage.formats.logger.units import EXAMPLES, QUANTITIES, scale

STANDARD_GRAVITY = 9.80665  # m/s², CGPM 1901
CHANNELS = GYRO + ACCEL
ENTRY = re.compile(r"(?:(gyro|accel)_)?([xyz])")
SIGNED = re.compile(r"([+\-−]?)(?:(gyro|accel)_)?([xyz])")


@dataclass(frozen=True)
class AxisMap:
    """matrices: of gyros and accelerometers, (3, 3), that the channels as recorded are multiplied
    by. text: as it was written.
    """

    text: str
    matrices: tuple[np.ndarray, np.ndarray]

    def applied(self, columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The columns with those of the triads that are there in their places."""
        made = dict(columns)
        for triad, matrix in zip((GYRO, ACCEL), self.matrices, strict=True):
            if set(triad) <= set(columns) and not np.array_equal(matrix, np.eye(3)):
                values = matrix @ np.array([columns[name] for name in triad])
                made |= dict(zip(triad, values, strict=True))
        return made


def axis_map(text: str) -> AxisMap:
    """The map that a text such as x=-y,y=x or gyro_z=-gyro_z says: NEW=OLD, of both triads where
    none is named; also all three in their order, as -y,x,z.

    Raises Unusable for what says none, and for one that takes an axis twice.
    """
    parts = [part.strip().lower() for part in text.split(",") if part.strip()]
    if len(parts) == len(AXES) and not any("=" in part for part in parts):
        parts = [f"{axis}={part}" for axis, part in zip(AXES, parts, strict=True)]
    matrices = (np.eye(3), np.eye(3))
    for part in parts:
        new, _, old = part.partition("=")
        to, source = ENTRY.fullmatch(new.strip()), SIGNED.fullmatch(old.strip())
        if to is None or source is None or (source[2] and source[2] != to[1]):
            raise Unusable(
                f"--axes {text}: {part!r} is no entry; write NEW=OLD, such as x=-y,y=x for both "
                "triads, or gyro_z=-gyro_z for one."
            )
        row = AXES.index(to[2])
        for triad, matrix in zip(("gyro", "accel"), matrices, strict=True):
            if to[1] in (None, triad):
                matrix[row] = (-1.0 if source[1] in ("-", "−") else 1.0) * np.eye(3)[
                    AXES.index(source[3])
                ]
    if any(abs(np.linalg.det(matrix)) != 1.0 for matrix in matrices):
        raise Unusable(
            f"--axes {text}: an axis is taken twice; say for each one where it comes from, such as "
            "x=y,y=x."
        )
    return AxisMap(text, matrices)


def pairs(option: str, text: str | None, names: tuple[str, ...]) -> dict[str, str]:
    """NAME=VALUE,… as a dict; a value may hold commas. Raises Unusable for unknown names."""
    found: dict[str, str] = {}
    name = ""
    for part in (text or "").split(","):
        head, sign, value = part.partition("=")
        if sign and head.strip() in names:
            name = head.strip()
            found[name] = value.strip()
        elif name and head.strip() and not (sign and head.strip().isidentifier()):
            found[name] += f",{part}"
        elif part.strip():
            raise Unusable(
                f"{option}: {part.strip()!r} names nothing that is known; write NAME=VALUE with "
                f"NAME one of {', '.join(names)}."
            )
    return found


@dataclass(frozen=True)
class Changes:
    """What an import changes. units: by gyro, accel, t, temperature, angle, table. gravity: m/s²
    that one g is, and local gravity; commanded_rate: half-width, relative, of how well the table
    holds the rates of the labels; None: not given.
    """

    units: Mapping[str, str] = field(default_factory=dict)
    axes: AxisMap | None = None
    shift: float = 0.0
    gravity: float | None = None
    commanded_rate: float | None = None

    def __bool__(self) -> bool:
        given = self.units or self.axes or self.shift or self.gravity or self.commanded_rate
        return bool(given)

    def of_table(self) -> dict[str, object]:
        """What the manifest says of the table's rates."""
        if self.commanded_rate is None:
            return {}
        bound = {"half_width": self.commanded_rate, "distribution": "rectangular"}
        return {"table_time": {"commanded_rate": bound}}

    def as_fields(self) -> dict[str, object]:
        """The changes as the manifest's fields."""
        made: dict[str, object] = {"units": dict(self.units)} if self.units else {}
        if self.axes:
            made["axes"] = self.axes.text
        if self.shift:
            made["shift_s"] = self.shift
        return made | ({"gravity_m_s2": self.gravity} if self.gravity else {})


UNIT_NAMES = ("t", "gyro", "accel", "temperature", "angle", "table", "labels")


def factor_of(name: str, unit: str, gravity: float) -> tuple[float, float]:
    """Factor and offset to SI of what --units names; raises Unusable for an unknown unit."""
    quantity = {"table": "angle", "labels": "time"}.get(name) or QUANTITIES[name]
    found = scale(quantity, unit, gravity)
    if found is None:
        raise Unusable(f"--units {name}={unit}: no such unit; it may be {EXAMPLES[quantity]}.")
    return found.factor, found.offset


def second_of(changes: Changes | None) -> float:
    """s that one of a recording's t is."""
    unit = changes.units.get("t") if changes else None
    return factor_of("t", unit, STANDARD_GRAVITY)[0] if unit else 1.0


def changed(recording: Recording, changes: Changes, *, is_timed: bool = False) -> Recording:
    """A copy of a recording with other units, axes and label times; its manifest says so.

    t is that of every stream; labels that would then lie beyond the recording are taken to be in
    the same unit, unless `labels` names another. is_timed: its times are in s already.
    """
    gravity = changes.gravity or recording.manifest.station.gravity_m_s2 or STANDARD_GRAVITY
    factors = {name: factor_of(name, unit, gravity) for name, unit in changes.units.items()}
    time = factors.get("t", (1.0, 0.0))[0]
    streams: dict[str, Any] = {
        name: Stream(
            stream.t * (1.0 if is_timed else time),
            _columns(name, stream.columns, factors, changes.axes),
        )
        for name, stream in recording.streams().items()
    }
    labels = recording.manifest.segments
    end = float(streams["imu"].t[-1])
    beyond = bool(labels) and max(label.t_end for label in labels or ()) > 2.0 * end
    scale_labels = factors["labels"][0] if "labels" in factors else time if beyond else 1.0
    moved = labels and tuple(_moved(label, scale_labels, changes.shift) for label in labels)
    station = recording.manifest.station
    if changes.gravity:
        station = station.model_copy(update={"gravity_m_s2": changes.gravity})
    stated = changes.of_table().get("table_time")
    if isinstance(stated, dict):
        stated = {**((recording.manifest.model_extra or {}).get("table_time") or {}), **stated}
    extra: dict[str, Any] = {"imported": {**changes.as_fields(), "source_digest": recording.digest}}
    extra |= {"table_time": stated} if stated else {}
    manifest = recording.manifest.model_copy(
        update={"segments": moved, "station": station, **extra}
    )
    return Recording(manifest, **streams, extra=recording.extra)


def _moved(label: Segment, factor: float, shift: float) -> Segment:
    times = {n: getattr(label, n) * factor + shift for n in ("t_start", "t_end")}
    return label.model_copy(update=times)


def _columns(
    stream: str, columns: Mapping[str, np.ndarray], factors: Mapping[str, tuple[float, float]],
    axes: AxisMap | None,
) -> dict[str, np.ndarray]:  # fmt: skip
    made = {}
    for name, values in columns.items():
        kind = (
            name.split("_")[0] if stream == "imu" else name if stream == "environment" else stream
        )
        factor, offset = factors.get(kind, (1.0, 0.0))
        made[name] = values * factor + offset if (factor, offset) != (1.0, 0.0) else values
    return axes.applied(made) if axes is not None and stream == "imu" else made
