"""Reads raw recordings: our own MCAP files, and any ROS 2 bag with one Imu topic."""

from dataclasses import replace
from functools import reduce
from pathlib import Path

import numpy as np

from schemas.base import Unusable
from schemas.recording import ANGLE, FORMAT, Manifest, Recording, Station, Stream, Unit
from storage.formats.checks import MAX_TIME_S, check_columns, check_stream
from storage.formats.content import NANO, as_raw, fingerprint, together
from storage.formats.manifest import manifest_of
from storage.formats.mcap.bag import Bag, Topic
from storage.formats.mcap.topics import (
    ANGLE_TOPIC,
    ENVIRONMENT,
    IMU,
    JOINTS,
    REFERENCE_TOPIC,
    TABLE_TOPIC,
    TEMPERATURE,
    UNIT_TEMPERATURE_TOPIC,
    joint_columns,
    named,
    pose_columns,
    triad_columns,
)

LAST_ORIGIN = 2**62  # ns, in 2116; an int64 holds it with room to subtract
DIGITS = len(str(LAST_ORIGIN))
Columns = dict[str, np.ndarray]
Timed = tuple[np.ndarray, Columns]  # stamps in ns and the columns at them


class CutOff(Unusable):
    """Of a file that is cut off or damaged only a part is whole. why: that, without its path."""

    why = ""


class NothingWhole(Unusable):
    """Of a file that is cut off no reading is whole. manifest: what it says all the same."""

    manifest: Manifest


def read_mcap(
    path: Path,
    *,
    files: tuple[Path, ...] | None = None,
    manifest: Manifest | None = None,
    salvage: bool = False,
    by_log_time: bool = False,
) -> Recording:
    """Reads a raw recording, or a ROS 2 bag with exactly one sensor_msgs/msg/Imu topic.

    A manifest that is given goes before the one in the file; where there is neither, one is
    made of what is known, which is nearly nothing. Epoch stamps are counted from the earliest.
    files: those of a bag that a folder holds. by_log_time: messages are stamped when they were
    recorded, and not by their headers. `extra["left_out"]` names topics of a foreign bag that could
    not be placed.
    Raises Unusable for what is no such file, for a fault in its data and, without `salvage`,
    for a file that is cut off or damaged; with it, what is whole is read.
    """
    file = Bag(path, files, by_log_time=by_log_time)
    # what this program wrote beside the messages; nothing in a foreign bag
    own = [record.metadata for record in file.metadata if record.name == FORMAT]
    try:
        imu = file.topic(_imu_topic(file))
    except NothingWhole as nothing:
        nothing.manifest = _manifest(file, own, salvage=True)
        raise
    if file.damage and not salvage:
        since = imu.stamps - _origin(own, [imu.stamps])
        why = (
            f"is cut off or damaged ({file.damage}): {len(since)} samples up to "
            f"t = {since[-1] / 1e9:.3f} s are whole"
        )
        fault = CutOff(f"{path} {why}; import it with --salvage to take them.")
        fault.why = why
        raise fault
    manifest = manifest or _manifest(file, own, salvage)
    extra = {}
    if own:
        timed = _our_streams(file, imu, salvage)
    else:
        timed, left_out = _foreign_streams(file, imu, manifest)
        extra = {"left_out": left_out} if left_out else {}
    origin = _origin(own, [stamps for stamps, _ in timed.values()])
    streams = {
        name: Stream((stamps - origin) / 1e9, columns) for name, (stamps, columns) in timed.items()
    }
    recording = as_raw(together(manifest, streams))
    _check(recording, path)
    return replace(recording, digest=fingerprint(recording), extra=extra)


def has_readings(path: Path) -> bool:
    """Whether a file may have any: one that cannot be read for another reason is for a person."""
    try:
        read_mcap(path, salvage=True)
    except NothingWhole:
        return False
    except Unusable:
        return bool(path.stat().st_size)
    return True


def _imu_topic(file: Bag) -> str:
    topics = file.of_kind(IMU)
    if len(topics) == 1:
        return topics[0]
    if topics:
        raise Unusable(
            f"{file.path}: {len(topics)} topics are of type {IMU} ({', '.join(topics)}); "
            "keep the one of the unit under test and convert the bag."
        )
    if file.damage:
        raise NothingWhole(
            f"{file.path} is cut off or damaged ({file.damage}) before any message of type {IMU} "
            f"is whole (found {file.described()}), so nothing can be salvaged; copy it again "
            "from where it was recorded, or record again."
        )
    raise Unusable(
        f"{file.path}: there is no message of type {IMU} in ROS 2 CDR (found "
        f"{file.described()}); give a bag of the unit's readings."
    )


def _manifest(file: Bag, own: list[dict[str, str]], salvage: bool) -> Manifest:
    """The last manifest in the file; in a damaged file the last that is whole."""
    for metadata in reversed(own):
        try:
            return manifest_of(metadata.get("manifest", ""), f"{file.path}, metadata {FORMAT}")
        except Unusable:
            if not salvage:
                raise
    unit = Unit(manufacturer="-", model="-", serial="-")
    station = Station(id="unknown")
    return Manifest(format=FORMAT, recording_id=file.path.stem, unit=unit, station=station)


def _origin(own: list[dict[str, str]], stamps: list[np.ndarray]) -> int:
    """The stamp in ns of time zero: as the file says, or the earliest if stamps are epochs."""
    if own:
        origin = own[-1].get("origin_ns", "0")
        known = int(origin) if origin.isdecimal() and len(origin) <= DIGITS else 0
        return known if known <= LAST_ORIGIN else 0
    earliest = min(int(times[0]) for times in stamps)
    return earliest if earliest > MAX_TIME_S * NANO else 0


def _our_streams(file: Bag, imu: Topic, salvage: bool) -> dict[str, Timed]:
    """Every stream of a file that this program wrote."""
    parts: list[Timed] = [(imu.stamps, triad_columns(imu.numbers))]
    for topic, names in ((UNIT_TEMPERATURE_TOPIC, ("temperature",)), (ANGLE_TOPIC, ANGLE)):
        if topic in file:
            companion = file.topic(topic)
            (values,) = (companion.numbers[f] for f in companion.numbers if f != "variance")
            parts.append((companion.stamps, named(names, values)))
    timed = {"imu": _side_by_side(file, parts, salvage)}
    if TABLE_TOPIC in file:
        timed["table"] = _table(file.topic(TABLE_TOPIC))
    if REFERENCE_TOPIC in file:
        pose = file.topic(REFERENCE_TOPIC)
        timed["reference"] = pose.stamps, pose_columns(pose.numbers)
    air = [
        (topic.stamps, {scalar.column: scalar.from_ros(topic.numbers[scalar.field][0])})
        for scalar in ENVIRONMENT
        if scalar.topic in file
        for topic in [file.topic(scalar.topic)]
    ]
    if air:
        timed["environment"] = _side_by_side(file, air, salvage)
    timed = {name: (stamps, columns) for name, (stamps, columns) in timed.items() if len(stamps)}
    if "imu" not in timed:
        raise Unusable(f"{file.path}: no reading of the unit is whole; nothing can be salvaged.")
    return timed


def _side_by_side(file: Bag, parts: list[Timed], salvage: bool) -> Timed:
    """Columns of several topics at the stamps they share; they share all in a whole file."""
    common = reduce(np.intersect1d, (s for s, _ in parts[1:]), parts[0][0]) if salvage else None
    stamps = parts[0][0] if common is None else common
    columns: Columns = {}
    for own, values in parts:
        if salvage:
            rows = np.isin(own, stamps, assume_unique=True)
            values = {n: v[rows] for n, v in values.items()}
        elif not np.array_equal(own, stamps):
            raise Unusable(
                f"{file.path}: column {next(iter(values))} has {len(own)} rows at other stamps "
                f"than the {len(stamps)} of its stream; import it with --salvage to take those "
                "they share."
            )
        columns |= values
    return stamps, columns


def _foreign_streams(
    file: Bag, imu: Topic, manifest: Manifest
) -> tuple[dict[str, Timed], tuple[str, ...]]:
    """The streams that a foreign bag gives without guessing, and the topics left out."""
    columns = triad_columns(imu.numbers)
    used = set(file.of_kind(IMU))
    warm = {name: file.topic(name) for name in file.of_kind(TEMPERATURE)}
    own = [name for name, topic in warm.items() if np.array_equal(topic.stamps, imu.stamps)]
    if len(own) == 1:
        columns["temperature"] = warm[own[0]].numbers["temperature"][0]
        used.add(own[0])
    timed = {"imu": (imu.stamps, columns)}
    joints = file.of_kind(JOINTS)
    axes = {axis.name for axis in manifest.station.table_axes or ()}
    if len(joints) == 1 and axes and axes <= set(file.topic(joints[0]).texts["name"]):
        timed["table"] = _table(file.topic(joints[0]))
        used.add(joints[0])
    return timed, tuple(sorted(file.names() - used))


def _table(topic: Topic) -> Timed:
    return topic.stamps, joint_columns(topic.texts["name"], topic.numbers)


def _check(recording: Recording, path: Path) -> None:
    for name, stream in recording.streams().items():
        where = f"{path}, stream {name}"
        check_columns(where, name, recording.manifest, set(stream.columns))
        check_stream(where, name, stream)
