"""The messages of an MCAP file grouped by topic, as arrays ordered by time stamp."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.records import Metadata

from schemas.base import Unusable
from storage.formats.content import NANO
from storage.formats.mcap.cdr import MalformedError, Texts, decode
from storage.formats.mcap.chunk_reader import Batch, Contents
from storage.formats.mcap.definitions import FIELDS
from storage.formats.mcap.files import scan_file

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
