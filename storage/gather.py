"""The messages of an MCAP file gathered by topic, as arrays in the order of their stamps."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from schemas.base import Unusable
from storage.cdr import FIELDS, MalformedError, Texts, decode
from storage.content import NANO
from storage.scan import Batch, Contents, scan

STAMP = ("sec", "nanosec")


@dataclass(frozen=True)
class Topic:
    """All messages of one topic.

    stamps: (n,) int64 ns, strictly rising; numbers: field -> (n, count), of a covariance only
    the first number, which says whether there is a measurement.
    """

    kind: str
    stamps: np.ndarray
    numbers: Mapping[str, np.ndarray]
    texts: Texts


@dataclass
class _Pieces:
    """What has been read of a topic so far."""

    kind: str
    stamps: list[np.ndarray] = field(default_factory=list)
    numbers: list[dict[str, np.ndarray]] = field(default_factory=list)
    texts: list[Texts] = field(default_factory=list)
    fault: str = ""

    def add(self, batch: Batch) -> None:
        try:
            for rows, view, texts in decode(self.kind, batch.block):
                names = view.dtype.names or ()
                self.stamps.append(_stamps(view) if STAMP[0] in names else batch.log_times[rows])
                self.numbers.append({n: _kept(n, view[n]) for n in names if n not in STAMP})
                self.texts.append(texts)
        except MalformedError as error:
            self.fault = self.fault or str(error)


class Gathered:
    """The topics of a file, by name, each put together when it is asked for."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._pieces: dict[str, _Pieces] = {}
        self._lost = ""
        try:
            self.contents = scan(path, self._take)
        except (ValueError, OSError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise Unusable(
                f"{path}: {reason}; give an MCAP file or a mimu-recording/1 folder."
            ) from error

    @property
    def damage(self) -> str:
        """Why the file is not whole, or nothing."""
        return self.contents.damage or self._lost

    def of_kind(self, kind: str) -> list[str]:
        """The names of the topics with messages of a type."""
        return sorted(name for name, pieces in self._pieces.items() if pieces.kind == kind)

    def __contains__(self, name: str) -> bool:
        return name in self._pieces

    def described(self) -> str:
        """The topics in the file with their types, for a sentence."""
        channels = self.contents.channels.values()
        found = {f"{c.topic} ({_kind(self.contents, c.schema_id)})" for c in channels}
        return ", ".join(sorted(found)) or "no topic"

    def topic(self, name: str) -> Topic:
        """A topic whole; raises Unusable for messages that do not fit together."""
        pieces = self._pieces[name]
        where = f"{self.path}, topic {name}"
        if pieces.fault:
            raise Unusable(f"{where}: a message is {pieces.fault}; record it as ROS 2 CDR.")
        names = {texts.get("name") for texts in pieces.texts}
        if len(names) > 1 or len({tuple(n) for n in pieces.numbers}) > 1:
            raise Unusable(
                f"{where}: the messages do not all carry the same fields and joints; "
                "split them into topics that do."
            )
        stamps = np.concatenate(pieces.stamps)
        numbers = {
            n: np.concatenate([piece[n] for piece in pieces.numbers]) for n in pieces.numbers[0]
        }
        if (np.diff(stamps) <= 0).any():
            order = np.argsort(stamps, kind="stable")
            stamps, numbers = stamps[order], {n: v[order] for n, v in numbers.items()}
            _check_single(where, stamps)
        return Topic(pieces.kind, stamps, numbers, pieces.texts[0])

    def _take(self, contents: Contents, batch: Batch) -> None:
        channel = contents.channels.get(batch.channel)
        if channel is None:
            self._lost = f"channel {batch.channel} is not described"
            return
        kind = _kind(contents, channel.schema_id)
        if kind in FIELDS and channel.message_encoding == "cdr":
            self._pieces.setdefault(channel.topic, _Pieces(kind)).add(batch)


def _kind(contents: Contents, schema_id: int) -> str:
    """The type as ROS 2 writes it, package/msg/Type."""
    schema = contents.schemas.get(schema_id)
    if schema is None:
        return "type unknown"
    package, _, name = schema.name.rpartition("/")
    return f"{package.removesuffix('/msg')}/msg/{name}"


def _stamps(view: np.ndarray) -> np.ndarray:
    return view["sec"][:, 0].astype(np.int64) * NANO + view["nanosec"][:, 0]


def _kept(name: str, values: np.ndarray) -> np.ndarray:
    return (values[:, :1] if name.endswith("covariance") else values).astype(np.float64)


def _check_single(where: str, stamps: np.ndarray) -> None:
    twice = np.flatnonzero(np.diff(stamps) == 0)
    if twice.size:
        seconds, rest = divmod(int(stamps[twice[0]]), NANO)
        raise Unusable(
            f"{where}: {twice.size + 1} or more messages share a stamp, the first at "
            f"{seconds}.{rest:09d} s; remove the repeated ones."
        )
