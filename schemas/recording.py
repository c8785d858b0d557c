"""A recording: its manifest (format `mimu-recording/1`) and its streams as arrays.

numpy is imported where arrays are made: the commands that list and show need none.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import hypot
from typing import TYPE_CHECKING, Any, Literal, Self

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, field_validator, model_validator

from schemas.base import Finite, Frozen
from schemas.text import Statement

if TYPE_CHECKING:
    import numpy as np

    from schemas.text import Remark


FORMAT: Literal["mimu-recording/1"] = "mimu-recording/1"
GYRO = ("gyro_x", "gyro_y", "gyro_z")
ACCEL = ("accel_x", "accel_y", "accel_z")
ANGLE = ("angle_x", "angle_y", "angle_z")
TRIADS = (GYRO, ACCEL)
SI_PER_UNIT = "si_per_unit"  # in `imported`: rad/s and m/s² that one of the source's units is
SEEN = "seen"  # in `imported`: what stood out in the source's columns and stamps
STREAMS = ("imu", "table", "reference", "environment")
ENVIRONMENT = ("temperature", "humidity", "supply_voltage", "pressure")  # columns of that stream

Axis = Literal["x", "y", "z"]
AXES: tuple[Axis, Axis, Axis] = ("x", "y", "z")
Up = Literal["+x", "-x", "+y", "-y", "+z", "-z"]
UPS: tuple[Up, ...] = ("+x", "-x", "+y", "-y", "+z", "-z")
Kind = Literal["static", "rate", "rotation", "settle", "transition"]
MEASURED: tuple[Kind, ...] = ("static", "rate", "rotation")
Standard = Literal["JJF 2003-2022", "JJF 1536-2015", "other"]
Vector = tuple[Finite, Finite, Finite]


class Received(BaseModel):
    """Frozen, but keeps fields it does not know: what others wrote must not be lost."""

    model_config = ConfigDict(frozen=True, extra="allow")


class Unit(Received):
    """The unit under test."""

    manufacturer: str
    model: str
    serial: str


class TableAxis(Received):
    """One axis of the turntable; `direction` is in the frame of the axis before it."""

    name: str = Field(min_length=1)
    direction: Vector

    @field_validator("direction")
    @classmethod
    def _not_zero(cls, direction: Vector) -> Vector:
        if not any(direction):
            raise ValueError("a table axis needs a direction that is not zero")
        return direction


class Mount(Received):
    """Attitude of the unit on the payload: R_n_body = R_n_payload · R(mount)."""

    quaternion_wxyz: tuple[Finite, Finite, Finite, Finite] = (1.0, 0.0, 0.0, 0.0)

    @field_validator("quaternion_wxyz")
    @classmethod
    def _of_unit_length(
        cls, quaternion: tuple[float, float, float, float]
    ) -> tuple[float, float, float, float]:
        if abs(hypot(*quaternion) - 1.0) > 1e-3:
            raise ValueError("a mount quaternion has length 1")
        return quaternion


class Station(Received):
    """The station of the recording. Null means unknown, and nothing assumes a value."""

    id: str
    latitude_deg: float | None = Field(default=None, ge=-90, le=90)
    gravity_m_s2: float | None = Field(default=None, gt=9.7, lt=9.9)
    height_m: float | None = Field(default=None, ge=-500, le=9000, description="above sea level")
    heading_deg: Finite | None = None
    table_axes: tuple[TableAxis, ...] | None = None


class Segment(Received):
    """A labelled part of the recording; times in s on the recording's time base.

    axis: of the unit, about which it turns. table_axis: of the table, outermost 0, where the unit
    is held aslant and turns about none of its own.
    """

    name: str
    kind: Kind
    t_start: Finite
    t_end: Finite
    item: str | None = None
    up: Up | None = None
    turn_deg: Finite | None = None
    axis: Axis | None = None
    table_axis: int | None = None
    rate_deg_s: Finite | None = None
    angle_deg: Finite | None = None
    mount: Mount | None = None

    @model_validator(mode="after")
    def _says_what_its_kind_needs(self) -> Self:
        if self.t_end < self.t_start:
            raise ValueError(f"segment {self.name} ends before it starts")
        about = self.axis if self.table_axis is None else self.table_axis
        if self.kind == "rate" and (about is None or self.rate_deg_s is None):
            raise ValueError(f"segment {self.name} of kind rate needs axis and rate_deg_s")
        if self.kind == "rotation" and (self.axis is None or self.angle_deg is None):
            raise ValueError(f"segment {self.name} of kind rotation needs axis and angle_deg")
        return self


class Manifest(Received):
    """`manifest.json`: unit, station, conditions and the labelled segments."""

    format: Literal["mimu-recording/1"]
    recording_id: str = Field(min_length=1)
    standard: Standard = "other"
    unit: Unit
    station: Station
    mount: Mount = Mount()
    streams: Mapping[str, str] = {}
    segments: tuple[Segment, ...] | None = None


@dataclass(frozen=True, eq=False)  # compared by identity: arrays have no single truth value
class Stream:
    """One time base and its columns.

    t: (n,) s, float64, strictly rising, whole nanoseconds.
    columns: name -> (n,) float64 in the units of `mimu-recording/1`; NaN where a triad was
        not recorded.
    span: s centred on its time over which each row is a mean: rates derived from angles, and the
    mean of both ends for other quantities; 0: each row is instantaneous.
    """

    t: "np.ndarray"
    columns: "Mapping[str, np.ndarray]"
    span: float = 0.0

    def __len__(self) -> int:
        return len(self.t)

    def channels(self, names: tuple[str, ...], rows: slice) -> "np.ndarray":
        """The named columns over some rows, (len(names), n); NaN for absent ones."""
        import numpy as np

        return np.array(self.views(names, rows)).reshape(len(names), -1)

    def views(self, names: tuple[str, ...], rows: slice) -> "list[np.ndarray]":
        """The named columns (n,) over some rows as they lie in memory; NaN for absent ones."""
        import numpy as np

        length = rows.stop - rows.start
        return [
            self.columns[name][rows] if name in self.columns else np.full(length, np.nan)
            for name in names
        ]

    def stack(self, names: tuple[str, ...], rows: slice | None = None) -> "np.ndarray":
        """The named columns side by side over all or some rows, (n, len(names))."""
        return self.channels(names, rows or slice(0, len(self.t))).T

    def at(self, rows: "slice | np.ndarray") -> "Stream":
        """The stream at some rows: a slice, or (n,) true where a row is kept."""
        columns = {name: values[rows] for name, values in self.columns.items()}
        return Stream(self.t[rows], columns, self.span)

    def rows(self, t_start: float, t_end: float) -> slice:
        """The rows with t_start ≤ t < t_end."""
        import numpy as np

        start, stop = np.searchsorted(self.t, (t_start, t_end))
        return slice(int(start), int(stop))


def joined(parts: Sequence[Stream]) -> Stream:
    """Streams of the same columns, one after the other; an empty one need not have them."""
    import numpy as np

    parts = [part for part in parts if len(part)] or parts[:1]
    names = parts[0].columns
    columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in names}
    return Stream(np.concatenate([part.t for part in parts]), columns)


@dataclass(frozen=True)
class WrongCodes:
    """How firmware had combined the bytes of one channel wrongly, before they were corrected.

    bug: signed-low, signed-low-or, bytes, unsigned, wrap, stuck-high or stuck-low. codes: by whole
    multiples of which readings were off; jump: that in rad/s or m/s². share: of the readings that
    were off. undecided: (n,) bool, readings that could not be put right.
    """

    channel: str
    bug: str
    codes: float
    jump: float
    share: float
    undecided: "np.ndarray"


@dataclass(frozen=True)
class Recording:
    """A whole recording in memory. `digest`: SHA-256 of its content (storage.formats.content).

    rate_errors: by how much (relative) the table's rate in a segment, by its name, is less than
    encoders and label say, as the certificate of the table has it. put_right: what was put right in
    the readings before anything was estimated; wrong_codes: what of their codes. These three are
    not in the file, which stays as it is.
    """

    manifest: Manifest
    imu: Stream
    table: Stream | None = None
    reference: Stream | None = None
    environment: Stream | None = None
    digest: str = ""
    extra: Mapping[str, Any] = field(default_factory=dict)
    rate_errors: Mapping[str, float] = field(default_factory=dict)
    put_right: "tuple[Remark, ...]" = ()
    wrong_codes: tuple[WrongCodes, ...] = ()

    def streams(self) -> dict[str, Stream]:
        """The streams that are present, by name."""
        every = {name: getattr(self, name) for name in STREAMS}
        return {name: stream for name, stream in every.items() if stream is not None}


# The log of a run, as kept in its manifest (`log`) and in its status.

State = Literal[
    "begun", "warming_up", "measuring", "repeating", "paused", "turning_over", "finishing",
    "done", "stopped",
]  # fmt: skip
ENDED: tuple[State, ...] = ("done", "stopped")


class LogEntry(Statement):
    """A change of a run's state, or an anomaly, with its cause as a sentence.

    at: UTC. t: s, on the time base of the recording's segments.
    """

    at: AwareDatetime
    t: Finite
    state: State


class Alarm(Statement):
    """An anomaly of a run, as a sentence with the number of its occurrences.

    code: the kind of anomaly, a message `station-alarm-…` of the catalogues, or `given_up`. at:
    when it was noticed last. Both are empty in a status that an earlier version wrote.
    """

    code: str = ""
    at: AwareDatetime | None = None


class RunStatus(Frozen):
    """The status of a run when its process last wrote it.

    units: serial numbers. at: time of writing. segment of segments: the one being measured.
    rates_hz: rows of each stream per second of station time. noise: standard deviation of single
    samples, deg/s and m/s². cause: why it stopped;
    shown_cause: the same for the pages, null from an earlier version. recordings: raw files being
    written. lock: the computer and the folder in which the run holds its station.
    """

    format: Literal["mimu-status/1"] = "mimu-status/1"
    station: str
    procedure: str
    units: tuple[str, ...] = ()
    process: int
    began_at: AwareDatetime
    at: AwareDatetime
    state: State
    now: str
    segment: int
    segments: int
    station_s_done: Finite
    station_s_total: Finite
    wall_s_left: Finite
    rates_hz: Mapping[str, Finite] = {}
    noise: Mapping[str, Finite] = {}
    alarms: tuple[Alarm, ...] = ()
    cause: str = ""
    shown_cause: Statement | None = None
    recordings: tuple[str, ...] = ()
    lock: str = ""


# Curves in a certificate's figures: a few points each, as drawn and as exported.

FigureName = Literal["rate-residuals", "tumble", "allan", "history"]
MAX_POINTS = 64


class Curve(Frozen):
    """The curve of one axis in a figure.

    quantity: the item or triad of its panel. U: k·u of each y. labels: for the tumble the axis that
    points up; for the history, except its last point, the certificates.
    """

    figure: FigureName
    quantity: str
    axis: Axis
    x_unit: str
    y_unit: str
    x: tuple[Finite, ...] = Field(min_length=1, max_length=MAX_POINTS)
    y: tuple[Finite, ...]
    U: tuple[Finite, ...]
    k: Finite
    labels: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _each_point_is_whole(self) -> Self:
        if not len(self.x) == len(self.y) == len(self.U) >= len(self.labels):
            raise ValueError(f"the curve {self.figure} {self.quantity} {self.axis} is not whole")
        return self
