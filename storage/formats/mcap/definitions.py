"""The definitions of the ROS 2 message types in a raw recording, as `ros2msg` schema text."""

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
    "sensor_msgs/Temperature": ("std_msgs/Header header\nfloat64 temperature\nfloat64 variance"),
    "sensor_msgs/RelativeHumidity": (
        "std_msgs/Header header\nfloat64 relative_humidity\nfloat64 variance"
    ),
    "sensor_msgs/FluidPressure": (
        "std_msgs/Header header\nfloat64 fluid_pressure\nfloat64 variance"
    ),
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\n"
        "float64[] position\nfloat64[] velocity\nfloat64[] effort"
    ),
}


def schema_text(kind: str) -> str:
    """The definition of `package/msg/Type`, and behind it those of the types it uses."""
    root = kind.replace("/msg/", "/")
    parts = [DEFINITIONS[root]]
    for used in _used_by(root):
        parts.append("=" * 80 + f"\nMSG: {used}\n{DEFINITIONS[used]}")
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
