"""The statistics of runs that `review` combines, kept once for each recording.

A file is a line of JSON and two bodies behind it, both Zstandard: the layout, which thousands of
runs share, and the arrays.
"""

import json
from functools import lru_cache, partial
from pathlib import Path

import numpy as np
import pyarrow as pa
from pydantic import ValidationError

from schemas.base import Unusable, first_fault
from schemas.discrepancy import KeptReview, Layout, RunStatistics
from storage.blobs import blobs_of
from storage.home import Home
from storage.whole_files import writing_to

FOLDER = "statistics"
CODEC = "zstd"
CHANNELS = 6


def name_of(digest: str) -> str:
    """Where the statistics of a recording are kept."""
    return f"{FOLDER}/{digest}"


def load(digest: str, version: int, home: Home) -> RunStatistics | None:
    """The statistics of a recording; None where they are not kept, were made by another version
    of what makes them, or are damaged: they can be made again.
    """
    blobs, name = blobs_of(home), name_of(digest)
    if not blobs.exists(name):
        return None
    with blobs.local(name) as path:
        try:
            return decoded(path.read_bytes(), version)
        except (ValueError, KeyError, OSError):
            return None


def keep_statistics(digest: str, version: int, statistics: RunStatistics, home: Home) -> None:
    """Keeps the statistics of a recording in the place of those of another version."""
    blobs, name = blobs_of(home), name_of(digest)
    if load(digest, version, home) is None:
        blobs.remove_file(name)
    blobs.keep(name, partial(_write, statistics, version))


def _write(statistics: RunStatistics, version: int, path: Path) -> None:
    path.write_bytes(encoded(statistics, version))


def encoded(statistics: RunStatistics, version: int) -> bytes:
    """The statistics as one file."""
    layout = statistics.layout.model_dump_json().encode()
    arrays = (
        statistics.correlation.astype("<i2"), statistics.right.astype("<f4"),
        statistics.scale.astype("<f4"), statistics.left_over.astype("<f4"),
    )  # fmt: skip
    body = b"".join(array.tobytes() for array in arrays)
    packed = [pa.compress(each, codec=CODEC, asbytes=True) for each in (layout, body)]
    head = {
        "format": "mimu-statistics/1",
        "version": version,
        "layout": statistics.layout_key,
        "parameters": len(statistics.right),
        "layout_bytes": [len(packed[0]), len(layout)],
        "body_bytes": [len(packed[1]), len(body)],
    }
    return b"".join([json.dumps(head).encode(), b"\n", *packed])


def decoded(content: bytes, version: int) -> RunStatistics:
    """The statistics of a file. Raises ValueError, KeyError or OSError where it is damaged, or was
    made by another version.
    """
    line, _, rest = content.partition(b"\n")
    head = json.loads(line)
    if head["version"] != version:
        raise ValueError(f"statistics of version {head['version']}")
    count, (short, whole) = head["parameters"], head["layout_bytes"]
    layout = _layout(head["layout"], rest[:short], whole)
    body = pa.decompress(rest[short:], head["body_bytes"][1], codec=CODEC, asbytes=True)
    pairs = count * (count + 1) // 2
    correlation = np.frombuffer(body, "<i2", pairs)
    floats = np.frombuffer(body, "<f4", 2 * count + CHANNELS, 2 * pairs)
    return RunStatistics(
        layout, head["layout"], correlation, floats[:count], floats[count : 2 * count],
        floats[2 * count :],
    )  # fmt: skip


@lru_cache(maxsize=256)
def _layout(key: str, content: bytes, size: int) -> Layout:
    text = pa.decompress(content, size, codec=CODEC, asbytes=True)
    return Layout.model_validate_json(text)


# The result of the last `mimucal review`, kept in the home folder.

NAME = "review.json"


def keep_review(kept: KeptReview, home: Home) -> None:
    """Keeps an answer in the place of the one before. Raises Unusable where the home only reads."""
    with writing_to(home.path / NAME) as draft:
        draft.write_text(kept.model_dump_json(indent=1), encoding="utf-8")


def last(home: Home) -> KeptReview | None:
    """The last answer; None without one. Raises Unusable for one that cannot be read."""
    path = home.path / NAME
    try:
        return KeptReview.model_validate_json(path.read_bytes())
    except FileNotFoundError:
        return None
    except OSError as error:
        raise Unusable(f"{path} cannot be read ({error.strerror}); grant access to it.") from error
    except ValidationError as error:
        raise Unusable(
            f"{path}: {first_fault(error)}; `mimucal review` writes it again."
        ) from error
