"""The definitions of the ROS 2 message types in a raw recording, as `ros2msg` schema text."""

from collections.abc import Iterator

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
