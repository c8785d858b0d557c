"""Reads raw recordings: our own MCAP files, and any ROS 2 bag with one Imu topic."""

import sqlite3
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import reduce
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

import numpy as np
import zstandard
from mcap.records import Channel, Metadata, Schema

from schemas.base import Unusable
from schemas.recording import ANGLE, FORMAT, Manifest, Recording, Station, Stream, Unit
from storage.formats.content import NANO, canonical, fingerprint, together
from storage.formats.manifest import MAX_TIME_S, check_columns, check_stream, manifest_of
from storage.formats.mcap.chunks import MAX_CHUNK_BYTES, Batch, Contents, scan
from storage.formats.mcap.messages import (
    ANGLE_TOPIC,
    ENVIRONMENT_TOPICS,
    FIELDS,
    IMU,
    JOINTS,
    REFERENCE_TOPIC,
    TABLE_TOPIC,
    TEMPERATURE,
    UNIT_TEMPERATURE_TOPIC,
    MalformedError,
    Texts,
    decode,
    joint_columns,
    named,
    pose_columns,
    triad_columns,
)

# The files of a bag: one MCAP file, parts of a split bag, SQLite storage, zstd around either.

METADATA = "metadata.yaml"  # beside the files of a rosbag2 folder
SUFFIXES = (".mcap", ".db3", ".mcap.zstd", ".db3.zstd")
SQLITE = b"SQLite format 3\0"
ZSTD = b"\x28\xb5\x2f\xfd"
BUFFER = 2**20
MESSAGES = 20_000  # rows of a database taken together

Piece = TypeVar("Piece")


def bag_files(folder: Path) -> tuple[Path, ...]:
    """The files of a rosbag2 folder in the order of its metadata; none where it has no metadata.

    Raises Unusable for metadata that names no file that is there, or that leaves open which.
    """
    described = folder / METADATA
    if not described.exists():
        return ()
    import yaml

    try:
        known = yaml.safe_load(described.read_text(encoding="utf-8"))["rosbag2_bagfile_information"]
        names = [str(name) for name in known["relative_file_paths"]]
    except (OSError, ValueError, KeyError, TypeError, yaml.YAMLError) as error:
        alone = [file for file in folder.iterdir() if file.name.lower().endswith(SUFFIXES)]
        if len(alone) == 1:
            return tuple(alone)
        raise Unusable(
            f"{folder} holds {len(alone)} MCAP files or databases, and {METADATA} does not say in "
            f"which order ({type(error).__name__}); run `ros2 bag reindex {folder}`, or give one "
            "of them."
        ) from error
    files = tuple(folder / Path(name).name for name in names)
    missing = [file.name for file in files if not file.is_file()]
    if missing or not files:
        raise Unusable(
            f"{described} names {', '.join(missing) or 'no file'}, which is not there; copy the "
            "bag whole, or give one of its files."
        )
    return files


def scan_file(
    path: Path, decode: Callable[[Contents, Batch], Piece], keep: Callable[[Piece], None]
) -> Contents:
    """Reads one file of a bag, whatever its storage, as `scan` reads MCAP."""
    with path.open("rb") as file:
        begins = file.read(len(SQLITE))
    if begins.startswith(ZSTD):
        with _unpacked(path) as whole:
            return scan_file(whole, decode, keep)
    if begins.startswith(SQLITE):
        return _scan_database(path, decode, keep)
    return scan(path, decode, keep)


@contextmanager
def _unpacked(path: Path) -> Iterator[Path]:
    """The file inside of one that is compressed as a whole, for as long as it is read."""
    with TemporaryDirectory() as folder:
        inside = Path(folder) / path.name.removesuffix(".zstd").removesuffix(".zst")
        try:
            with path.open("rb") as packed, inside.open("wb") as file:
                zstandard.ZstdDecompressor().copy_stream(packed, file, BUFFER, BUFFER)
        except zstandard.ZstdError as error:
            raise ValueError(f"cannot be unpacked ({error}); try `zstd -d {path}`") from error
        yield inside


def _scan_database(
    path: Path, decode: Callable[[Contents, Batch], Piece], keep: Callable[[Piece], None]
) -> Contents:
    contents = Contents()
    connection = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro&immutable=1", uri=True)
    try:
        topics = connection.execute("SELECT id, name, type, serialization_format FROM topics")
        for topic, name, kind, encoding in topics.fetchall():
            contents.schemas[topic] = Schema(id=topic, name=kind, encoding="", data=b"")
            contents.channels[topic] = Channel(
                id=topic, topic=name, message_encoding=encoding, metadata={}, schema_id=topic
            )
        rows = connection.execute(
            "SELECT topic_id, length(data), timestamp, data FROM messages "
            "ORDER BY topic_id, length(data), timestamp, id"
        )
        for (topic, _), alike in groupby(rows, key=lambda row: row[:2]):
            for batch in _batches(topic, alike):
                keep(decode(contents, batch))
    except sqlite3.DatabaseError as error:
        if not contents.channels:
            raise ValueError(
                f"is a database without the tables of a bag ({error}); convert it with `ros2 bag "
                "convert`"
            ) from error
        contents.damage = f"the database is damaged: {error}"
    finally:
        connection.close()
    return contents


def _batches(topic: int, rows: Iterator[tuple[int, int, int, bytes]]) -> Iterator[Batch]:
    """Messages of one topic and stored length, unpacked where each is compressed by itself."""
    unpack = zstandard.ZstdDecompressor()
    times: list[int] = []
    blocks: list[bytes] = []

    def batch() -> Batch:
        block = np.frombuffer(b"".join(blocks), np.uint8).reshape(len(blocks), -1)
        return Batch(topic, np.array(times, np.int64), block)

    for _, _, time, data in rows:
        if data[:4] == ZSTD:
            data = unpack.decompress(data, max_output_size=MAX_CHUNK_BYTES)
        if blocks and (len(data) != len(blocks[0]) or len(blocks) == MESSAGES):
            yield batch()
            times, blocks = [], []
        times.append(time)
        blocks.append(data)
    if blocks:
        yield batch()


# The messages of an MCAP file grouped by topic, as arrays ordered by time stamp.

UNSET = 3  # messages that share one stamp: it was never set
STAMP = ("sec", "nanosec")


@dataclass(frozen=True)
class Topic:
    """All messages of one topic.

    stamps: (n,) int64 ns, strictly rising; logged: (n,) int64 ns, when they were recorded;
    numbers: field -> (count, n), of a covariance only the first number, which says whether there is
    a measurement.
    """

    kind: str
    stamps: np.ndarray
    logged: np.ndarray
    numbers: Mapping[str, np.ndarray]
    texts: Texts


@dataclass(frozen=True)
class _Decoded:
    """A batch of messages, decoded: as many topics as it has layouts, or why it could not be."""

    name: str = ""
    parts: tuple[Topic, ...] = ()
    fault: str = ""
    lost: str = ""


class Bag:
    """The topics of a bag's files, by name, each put together when it is asked for.

    path: names the bag in sentences. by_log_time: messages are stamped when they were recorded.
    """

    def __init__(
        self, path: Path, files: tuple[Path, ...] | None = None, *, by_log_time: bool = False
    ) -> None:
        self.path = path
        self._by_log_time = by_log_time
        self._parts: dict[str, list[Topic]] = {}
        self._faults: dict[str, str] = {}
        self._lost = ""
        try:
            self._each = [scan_file(file, _decoded, self._keep) for file in files or (path,)]
        except (ValueError, OSError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise Unusable(
                f"{path}: {reason}; give an MCAP file or a mimu-recording/1 folder."
            ) from error

    @property
    def damage(self) -> str:
        """Why the file is not whole, or nothing."""
        return next((each.damage for each in self._each if each.damage), self._lost)

    @property
    def metadata(self) -> list[Metadata]:
        """The metadata records of all files."""
        return [record for each in self._each for record in each.metadata]

    def names(self) -> set[str]:
        """Every topic that the file describes, with messages or without."""
        return {channel.topic for each in self._each for channel in each.channels.values()}

    def of_kind(self, kind: str) -> list[str]:
        """The names of the topics with messages of a type."""
        return sorted(name for name, parts in self._parts.items() if parts[0].kind == kind)

    def __contains__(self, name: str) -> bool:
        return name in self._parts

    def described(self) -> str:
        """The topics in the file with their types, for a sentence."""
        topics = {
            f"{channel.topic} ({_kind(each, channel.schema_id)})"
            for each in self._each
            for channel in each.channels.values()
        }
        return ", ".join(sorted(topics)) or "no topic"

    def topic(self, name: str) -> Topic:
        """A topic whole; raises Unusable for messages that do not fit together."""
        parts = self._parts[name]
        where = f"{self.path}, topic {name}"
        if name in self._faults:
            raise Unusable(f"{where}: a message is {self._faults[name]}; record it as ROS 2 CDR.")
        if len({(part.texts.get("name"), tuple(part.numbers)) for part in parts}) > 1:
            raise Unusable(
                f"{where}: the messages do not all carry the same fields and joints; "
                "split them into topics that do."
            )
        logged = np.concatenate([part.logged for part in parts])
        stamps = np.concatenate([part.stamps for part in parts])
        if self._by_log_time:
            stamps = logged
        elif len(stamps) >= UNSET and (stamps == stamps[0]).all():
            raise Unusable(
                f"{where}: the stamps in the headers of its {len(stamps)} messages were never set "
                f"(all {stamps[0] / NANO:g} s); import it with --stamps log to take the times at "
                f"which they were recorded, over {np.ptp(logged) / NANO:.3f} s."
            )
        numbers = {
            n: np.concatenate([part.numbers[n] for part in parts], axis=1) for n in parts[0].numbers
        }
        if (np.diff(stamps) <= 0).any():
            order = np.argsort(stamps, kind="stable")
            stamps, numbers = stamps[order], {n: v[:, order] for n, v in numbers.items()}
            logged = logged[order]
            _check_single(where, stamps, logged)
        return Topic(parts[0].kind, stamps, logged, numbers, parts[0].texts)

    def _keep(self, decoded: _Decoded) -> None:
        self._lost = self._lost or decoded.lost
        if decoded.fault:
            self._faults.setdefault(decoded.name, decoded.fault)
        if decoded.parts:
            self._parts.setdefault(decoded.name, []).extend(decoded.parts)


def _decoded(contents: Contents, batch: Batch) -> _Decoded:
    channel = contents.channels.get(batch.channel)
    if channel is None:
        return _Decoded(lost=f"channel {batch.channel} is not described")
    kind = _kind(contents, channel.schema_id)
    if kind not in FIELDS or channel.message_encoding != "cdr":
        return _Decoded()
    try:
        parts = [
            _part(kind, batch.log_times[rows], view, texts)
            for rows, view, texts in decode(kind, batch.block)
        ]
    except MalformedError as error:
        return _Decoded(channel.topic, fault=str(error))
    return _Decoded(channel.topic, tuple(parts))


def _part(kind: str, log_times: np.ndarray, view: np.ndarray, texts: Texts) -> Topic:
    names = view.dtype.names or ()
    stamps = log_times
    if STAMP[0] in names:
        stamps = view["sec"][:, 0].astype(np.int64) * NANO + view["nanosec"][:, 0]
    return Topic(
        kind, stamps, log_times, {n: _kept(n, view[n]) for n in names if n not in STAMP}, texts
    )


def _kind(contents: Contents, schema_id: int) -> str:
    """The type as ROS 2 writes it, package/msg/Type."""
    schema = contents.schemas.get(schema_id)
    if schema is None:
        return "type unknown"
    package, _, name = schema.name.rpartition("/")
    return f"{package.removesuffix('/msg')}/msg/{name}"


def _kept(name: str, values: np.ndarray) -> np.ndarray:
    values = values[:, :1] if name.endswith("covariance") else values
    return values.T.astype(np.float64, order="C")


def _check_single(where: str, stamps: np.ndarray, logged: np.ndarray) -> None:
    twice = np.flatnonzero(np.diff(stamps) == 0)
    if twice.size:
        seconds, rest = divmod(int(stamps[twice[0]]), NANO)
        raise Unusable(
            f"{where}: {twice.size + 1} or more messages share a stamp, the first at "
            f"{seconds}.{rest:09d} s; remove the repeated ones{_or_logged(logged)}."
        )


def _or_logged(logged: np.ndarray) -> str:
    """Another way out where the times of recording all differ."""
    return ", or import it with --stamps log" if (np.diff(np.sort(logged)) > 0).all() else ""


LAST_ORIGIN = 2**62  # ns, in 2116; an int64 holds it with room to subtract
DIGITS = len(str(LAST_ORIGIN))
Columns = dict[str, np.ndarray]
Timed = tuple[np.ndarray, Columns]  # stamps in ns and the columns at them


class CutOff(Unusable):
    """Of a file that is cut off or damaged only a part is whole. why: that, without its path."""

    why = ""


class NothingWhole(Unusable):
    """Of a file that is cut off no reading is whole. manifest: what it says all the same."""

    def __init__(self, sentence: str, manifest: Manifest) -> None:
        super().__init__(sentence)
        self.manifest = manifest


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
    imu = file.topic(_imu_topic(file, own))
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
        timed = _our_streams(file, imu, manifest, salvage)
    else:
        timed, left_out = _foreign_streams(file, imu, manifest)
        extra = {"left_out": left_out} if left_out else {}
    origin = _origin(own, [stamps for stamps, _ in timed.values()])
    streams = {
        name: Stream((stamps - origin) / 1e9, columns) for name, (stamps, columns) in timed.items()
    }
    recording = canonical(together(manifest, streams))
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


def _imu_topic(file: Bag, own: list[dict[str, str]]) -> str:
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
            "from where it was recorded, or record again.",
            _manifest(file, own, salvage=True),
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


def _our_streams(file: Bag, imu: Topic, manifest: Manifest, salvage: bool) -> dict[str, Timed]:
    """Every stream of a file that this program wrote."""
    introduced = file.names()
    parts: list[Timed] = [(imu.stamps, triad_columns(imu.numbers))]
    for topic, names in ((UNIT_TEMPERATURE_TOPIC, ("temperature",)), (ANGLE_TOPIC, ANGLE)):
        if topic in file:
            companion = file.topic(topic)
            (values,) = (companion.numbers[f] for f in companion.numbers if f != "variance")
            parts.append((companion.stamps, named(names, values)))
        elif salvage and topic in introduced:  # it was cut off before the first of them
            parts.append((imu.stamps[:0], dict.fromkeys(names, imu.stamps[:0].astype(float))))
    timed = {"imu": _side_by_side(file, parts, salvage)}
    if TABLE_TOPIC in file:
        timed["table"] = _table(file.topic(TABLE_TOPIC))
    if REFERENCE_TOPIC in file:
        pose = file.topic(REFERENCE_TOPIC)
        timed["reference"] = pose.stamps, pose_columns(pose.numbers)
    air = [
        (topic.stamps, {scalar.column: scalar.from_ros(topic.numbers[scalar.field][0])})
        for scalar in ENVIRONMENT_TOPICS
        if scalar.topic in file
        for topic in [file.topic(scalar.topic)]
    ]
    begun = all(
        scalar.topic in file or scalar.topic not in introduced for scalar in ENVIRONMENT_TOPICS
    )
    if air and (begun or not salvage):
        timed["environment"] = _side_by_side(file, air, salvage)
    timed = {name: (stamps, columns) for name, (stamps, columns) in timed.items() if len(stamps)}
    if "imu" not in timed:
        raise NothingWhole(
            f"{file.path}: no reading of the unit is whole; nothing can be salvaged.", manifest
        )
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
