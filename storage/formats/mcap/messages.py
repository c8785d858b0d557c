"""The ROS 2 messages of a raw recording: definitions, CDR, and topics."""

import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from schemas.recording import ACCEL, ANGLE, GYRO, Stream
from storage.formats.manifest import PLACE

# The definitions of the ROS 2 message types in a raw recording, as `ros2msg` schema text.

_SCALAR = "std_msgs/Header header\nfloat64 {}\nfloat64 variance"
_COVARIED = "geometry_msgs/{0} {1}\nfloat64[9] {1}_covariance"

DEFINITIONS: dict[str, str] = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "std_msgs/Float64": "float64 data",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
    "geometry_msgs/Vector3Stamped": "std_msgs/Header header\ngeometry_msgs/Vector3 vector",
    "sensor_msgs/Imu": "\n".join(
        (
            "std_msgs/Header header",
            _COVARIED.format("Quaternion", "orientation"),
            _COVARIED.format("Vector3", "angular_velocity"),
            _COVARIED.format("Vector3", "linear_acceleration"),
        )
    ),
    "sensor_msgs/Temperature": _SCALAR.format("temperature"),
    "sensor_msgs/RelativeHumidity": _SCALAR.format("relative_humidity"),
    "sensor_msgs/FluidPressure": _SCALAR.format("fluid_pressure"),
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\n"
        "float64[] position\nfloat64[] velocity\nfloat64[] effort"
    ),
}


Field = tuple[str, str, int]  # name, type as numpy writes it or "text", number of elements
SEQUENCE = 0  # a field of so many elements carries their number itself
PRIMITIVES = {"float64": "f8", "int32": "i4", "uint32": "u4", "string": "text"}


def schema_text(kind: str) -> str:
    """The definition of `package/msg/Type`, and behind it those of the types it uses."""
    root = kind.replace("/msg/", "/")
    parts = [DEFINITIONS[root]]
    parts += ["=" * 80 + f"\nMSG: {used}\n{DEFINITIONS[used]}" for used in _used_by(root)]
    return "\n".join(parts) + "\n"


def _used_by(root: str) -> list[str]:
    used: list[str] = []
    queue = [root]
    while queue:
        for line in DEFINITIONS[queue.pop(0)].splitlines():
            name = line.split()[0]
            if name in DEFINITIONS and name not in used:
                used.append(name)
                queue.append(name)
    return used


def _fields(root: str) -> Iterator[Field]:
    """The fields of a type in their order; numbers side by side in a part are one field."""
    for line in DEFINITIONS[root].splitlines():
        kind, name = line.split()
        kind, _, count = kind.partition("[")
        if kind in PRIMITIVES:
            elements = int(count.strip("]") or SEQUENCE) if count else 1
            yield name, PRIMITIVES[kind], elements
            continue
        parts = list(_fields(kind))
        if all(part[1:] == ("f8", 1) for part in parts):
            yield name, "f8", len(parts)
        else:
            yield from parts


def _messages() -> dict[str, tuple[Field, ...]]:
    parts = {used for root in DEFINITIONS for used in _used_by(root)}
    roots = [root for root in DEFINITIONS if root not in parts]
    return {root.replace("/", "/msg/"): tuple(_fields(root)) for root in roots}


FIELDS = _messages()  # of each type of message, `package/msg/Type`


# ROS 2 messages as bytes: CDR for the few message types that a recording uses.
#
# OMG CDR as ROS 2 puts it on the wire (DDS-XTypes, encoding version 1): four bytes that name the
# byte order, then the fields one after the other, each aligned to its size (8 at most) from
# there. Many messages of one layout are coded at once, as the rows of a (n, length) array.

ORIGIN = 4  # alignment counts from behind the four bytes that name the byte order
Texts = Mapping[str, tuple[str, ...]]


class MalformedError(ValueError):
    """Bytes that are not a message of the type of their channel."""


@dataclass(frozen=True)
class Layout:
    """Where the fields of a message lie.

    numbers: a structured dtype as long as the message, one (count,) entry for each number field.
    texts: the text fields, which are the same in every message of this layout.
    fixed: the bytes that decide the layout: byte order, lengths and texts.
    """

    numbers: np.dtype
    texts: Texts
    fixed: tuple[slice, ...]


def layout(kind: str, message: bytes) -> Layout:
    """The layout of one message; raises MalformedError when it ends before its last field."""
    try:
        return _walk(kind, message)
    except (struct.error, UnicodeDecodeError) as error:
        raise MalformedError(f"not a {kind} in CDR") from error


def _walk(kind: str, message: bytes) -> Layout:
    orders = {b"\0\0": ">", b"\0\1": "<"}
    if message[:2] not in orders:
        raise MalformedError(
            f"an encapsulation {message[:2].hex() or 'of no bytes'} that is not CDR"
        )
    order = orders[message[:2]]
    at = ORIGIN
    texts: dict[str, tuple[str, ...]] = {}
    numbers: dict[str, tuple[str, tuple[int], int]] = {}
    fixed = [slice(0, ORIGIN)]
    for name, code, count in FIELDS[kind]:
        start = at
        if count == SEQUENCE:
            count, at = _word(order, message, at)
        if code == "text":
            texts[name], at = _texts(order, message, at, count)
            fixed.append(slice(start, at))
            continue
        fixed.append(slice(start, at))
        size = int(code[1])
        if count:
            at = _aligned(at, size)
            numbers[name] = (order + code, (count,), at)
        at += count * size
        if at > len(message):
            raise MalformedError(f"a {kind} that ends before its field {name}")
    dtype = np.dtype(
        {
            "names": list(numbers),
            "formats": [(code, shape) for code, shape, _ in numbers.values()],
            "offsets": [offset for _, _, offset in numbers.values()],
            "itemsize": len(message),
        }
    )
    return Layout(dtype, texts, tuple(part for part in fixed if part.start < part.stop))


def _aligned(at: int, size: int) -> int:
    return at + (ORIGIN - at) % size


def _word(order: str, message: bytes, at: int) -> tuple[int, int]:
    at = _aligned(at, 4)
    return struct.unpack_from(order + "I", message, at)[0], at + 4


def _texts(order: str, message: bytes, at: int, count: int) -> tuple[tuple[str, ...], int]:
    texts = []
    for _ in range(count):
        length, at = _word(order, message, at)
        if at + length > len(message):
            raise MalformedError("a text that is longer than its message")
        texts.append(message[at : at + max(length - 1, 0)].decode())
        at += length
    return tuple(texts), at


def decode(kind: str, block: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, Texts]]:
    """The messages in `block`, (n, length) uint8, by layout.

    Yields (rows, numbers, texts): row numbers (k,), a structured view (k,) whose fields are
    (k, count) arrays, and the texts these messages share. Messages of one sender have one
    layout, so that this nearly always yields once, and copies nothing.
    """
    rest = np.arange(len(block))
    while len(rest):
        form = layout(kind, block[rest[0]].tobytes())
        part = block if len(rest) == len(block) else block[rest]
        alike = np.ones(len(part), dtype=bool)
        for fixed in form.fixed:
            whole = part[:, fixed].view(f"S{fixed.stop - fixed.start}")[:, 0]
            alike &= whole == whole[0]
        if not alike.all():
            part = part[alike]
        yield rest[alike], part.view(form.numbers)[:, 0], form.texts
        rest = rest[~alike]


def encode(kind: str, numbers: Mapping[str, np.ndarray], texts: Texts) -> np.ndarray:
    """Messages as the rows of a (n, length) uint8 array, little-endian.

    numbers: field -> (n, count); a field that is left out is zero, or empty if a sequence.
    """
    rows = len(next(iter(numbers.values())))
    counts = {name: values.shape[1] for name, values in numbers.items()}
    blank = _blank(kind, counts, texts)
    block = np.tile(np.frombuffer(blank, dtype=np.uint8), (rows, 1))
    view = block.view(_walk(kind, blank).numbers)[:, 0]
    for name, values in numbers.items():
        if len(values) != rows:
            raise ValueError(f"{name} has {len(values)} rows, the fields before it {rows}")
        view[name] = values
    return block


def _blank(kind: str, counts: Mapping[str, int], texts: Texts) -> bytes:
    """One message with its lengths and texts in place and every number zero."""
    message = bytearray(b"\0\1\0\0")

    def align(size: int) -> None:
        message.extend(bytes(_aligned(len(message), size) - len(message)))

    for name, code, count in FIELDS[kind]:
        words = [text.encode() + b"\0" for text in texts.get(name, ())]
        if count == SEQUENCE:
            count = len(words) if code == "text" else counts.get(name, 0)
            align(4)
            message += struct.pack("<I", count)
        if code == "text":
            for word in words:
                align(4)
                message += struct.pack("<I", len(word)) + word
        elif count:
            align(int(code[1]))
            message += bytes(count * int(code[1]))
    return bytes(message)


# Which column of a recording corresponds to which field of which ROS 2 topic.
#
# Both directions stand side by side, and going there and back twice gives the same numbers as
# going once, so that a recording keeps its digest however often it is written and read.

IMU = "sensor_msgs/msg/Imu"
TEMPERATURE = "sensor_msgs/msg/Temperature"
JOINTS = "sensor_msgs/msg/JointState"
POSE = "geometry_msgs/msg/PoseStamped"
VECTOR = "geometry_msgs/msg/Vector3Stamped"
HUMIDITY = "sensor_msgs/msg/RelativeHumidity"
PRESSURE = "sensor_msgs/msg/FluidPressure"
NUMBER = "std_msgs/msg/Float64"  # voltage: BatteryState has only single precision for it

IMU_TOPIC = "/imu/data"
ANGLE_TOPIC = "/imu/angle"
UNIT_TEMPERATURE_TOPIC = "/imu/temperature"
TABLE_TOPIC = "/table"
REFERENCE_TOPIC = "/reference/pose"

ATTITUDE = ("qx", "qy", "qz", "qw")  # the order of geometry_msgs/Quaternion
TRIAD_FIELDS = ((GYRO, "angular_velocity"), (ACCEL, "linear_acceleration"))


@dataclass(frozen=True)
class Messages:
    """The messages of one topic: field -> (n, count), and the texts they share."""

    topic: str
    kind: str
    numbers: Mapping[str, np.ndarray]
    texts: Texts


@dataclass(frozen=True)
class Scalar:
    """A column that has a topic of its own, with a factor from its unit to that of ROS 2."""

    column: str
    topic: str
    kind: str
    field: str
    per_unit: float = 1.0

    def to_ros(self, values: np.ndarray) -> np.ndarray:
        return values if self.per_unit == 1.0 else values * self.per_unit

    def from_ros(self, values: np.ndarray) -> np.ndarray:
        """Back to the unit of the column; to 15 digits where that takes a conversion.

        A decimal number of 15 digits survives two roundings of a double: one that was written
        with no more digits comes back as it was, and any other changes once and never again.
        """
        if self.per_unit == 1.0:
            return values
        return np.array([float(f"{value:.15g}") for value in values / self.per_unit])


ENVIRONMENT_TOPICS = (
    Scalar("temperature", "/environment/temperature", TEMPERATURE, "temperature"),
    Scalar("humidity", "/environment/humidity", HUMIDITY, "relative_humidity", per_unit=0.01),
    Scalar("pressure", "/environment/pressure", PRESSURE, "fluid_pressure", per_unit=100.0),
    Scalar("supply_voltage", "/environment/supply_voltage", NUMBER, "data"),
)


def imu_messages(stream: Stream) -> Iterator[Messages]:
    """The imu stream; covariance[0] = -1 marks a triad not recorded, as in ROS."""
    rows = len(stream)
    numbers = {
        "orientation": np.tile([0.0, 0.0, 0.0, 1.0], (rows, 1)),
        "orientation_covariance": _covariance(np.ones(rows, dtype=bool)),
    }
    for triad, field in TRIAD_FIELDS:
        values = stream.stack(triad)
        absent = np.isnan(values).all(axis=1)
        numbers[field] = np.where(absent[:, None], 0.0, values)
        numbers[f"{field}_covariance"] = _covariance(absent)
    texts = {"frame_id": ("imu",)}
    yield Messages(IMU_TOPIC, IMU, numbers, texts)
    if "temperature" in stream.columns:
        warmth = {"temperature": stream.stack(("temperature",))}
        yield Messages(UNIT_TEMPERATURE_TOPIC, TEMPERATURE, warmth, texts)
    if ANGLE[0] in stream.columns:
        yield Messages(ANGLE_TOPIC, VECTOR, {"vector": stream.stack(ANGLE)}, texts)


def table_messages(stream: Stream) -> Iterator[Messages]:
    """The table stream: one joint for each axis; an axis without rate has NaN for it."""
    axes = tuple(n.removesuffix("_angle") for n in stream.columns if n.endswith("_angle"))
    numbers = {"position": stream.stack(tuple(f"{axis}_angle" for axis in axes))}
    rates = tuple(f"{axis}_rate" for axis in axes)
    if any(rate in stream.columns for rate in rates):
        numbers["velocity"] = stream.stack(rates)
    yield Messages(TABLE_TOPIC, JOINTS, numbers, {"frame_id": ("table",), "name": axes})


def reference_messages(stream: Stream) -> Iterator[Messages]:
    """The reference stream; a pose without place has NaN for it."""
    numbers = {"position": stream.stack(PLACE), "orientation": stream.stack(ATTITUDE)}
    yield Messages(REFERENCE_TOPIC, POSE, numbers, {"frame_id": ("n",)})


def environment_messages(stream: Stream) -> Iterator[Messages]:
    """The environment stream: each column has its own topic."""
    for scalar in ENVIRONMENT_TOPICS:
        if scalar.column in stream.columns:
            values = scalar.to_ros(stream.columns[scalar.column])[:, None]
            texts = {} if scalar.kind == NUMBER else {"frame_id": ("environment",)}
            yield Messages(scalar.topic, scalar.kind, {scalar.field: values}, texts)


MESSAGES: dict[str, Callable[[Stream], Iterator[Messages]]] = {
    "imu": imu_messages,
    "table": table_messages,
    "reference": reference_messages,
    "environment": environment_messages,
}


def triad_columns(numbers: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The six columns of Imu messages, with NaN where covariance[0] = -1.

    As in all that follows, numbers: field -> (count, n).
    """
    columns: dict[str, np.ndarray] = {}
    for triad, field in TRIAD_FIELDS:
        absent = numbers[f"{field}_covariance"][:1] == -1.0
        values = numbers[field]
        columns |= named(triad, np.where(absent, np.nan, values) if absent.any() else values)
    return columns


def joint_columns(axes: tuple[str, ...], numbers: Mapping[str, np.ndarray]) -> dict:
    """The columns of JointState messages; what is NaN in every row is absent."""
    columns = named(tuple(f"{axis}_angle" for axis in axes), numbers["position"])
    rates = numbers.get("velocity", np.empty((0, 0)))
    return columns | present(named(tuple(f"{axis}_rate" for axis in axes), rates))


def pose_columns(numbers: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The columns of PoseStamped messages; a place that is NaN in every row is absent."""
    return named(ATTITUDE, numbers["orientation"]) | present(named(PLACE, numbers["position"]))


def present(columns: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The columns that hold a number somewhere."""
    return {name: values for name, values in columns.items() if not np.isnan(values).all()}


def named(names: tuple[str, ...], values: np.ndarray) -> dict[str, np.ndarray]:
    """The rows of a (k, n) array by name; fewer where k is smaller."""
    return dict(zip(names, values, strict=False))


def _covariance(absent: np.ndarray) -> np.ndarray:
    """(n, 9) zeros, which say unknown, with -1 in front where there is no measurement."""
    values = np.zeros((len(absent), 9))
    values[absent, 0] = -1.0
    return values
