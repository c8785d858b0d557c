"""Which column of a recording corresponds to which field of which ROS 2 topic.

Both directions stand side by side, and going there and back twice gives the same numbers as
going once, so that a recording keeps its digest however often it is written and read.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from schemas.recording import ACCEL, ANGLE, GYRO, Stream
from storage.formats.checks import PLACE
from storage.formats.mcap.cdr import Texts

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


ENVIRONMENT = (
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
    for scalar in ENVIRONMENT:
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
