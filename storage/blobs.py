"""Where raw recordings and their columns are kept: a folder, or an S3 bucket.

MIMUCAL_STORE names the bucket as s3://BUCKET/PREFIX, with `endpoint`, `scheme` and `region` behind
a question mark where it is not AWS; without it they are in the home. Keys come from the
environment, as AWS names them, or stand as KEY:SECRET@ before the bucket.
"""

import json
import os
import re
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol
from urllib.parse import parse_qsl, urlsplit

from schemas.base import Unusable, login_apart, shown
from storage.home import Home, environment
from storage.whole_files import writing_in_home, writing_to

WAY_OUT = "give it as s3://BUCKET/PREFIX, with ?endpoint=HOST:PORT&scheme=http where it is not AWS"
OPTIONS = {"endpoint": "endpoint_override", "scheme": "scheme", "region": "region"}
ATTEMPTS = 8  # of each request, with growing pauses: about half a minute
REQUEST_S, CONNECT_S = 60.0, 10.0
REQUESTED = 16 * 2**20  # bytes at a time
PLAIN_NAME = re.compile(r"\w[\w.-]{0,99}")  # of a stream's file
WHOLE_LAST = "manifest.json"  # uploaded after the rest: a folder that has it is whole

Write = Callable[[Path], None]


class Unreachable(Unusable):
    """The bucket does not answer, or refuses; trying again may succeed."""


@dataclass(frozen=True)
class Kept:
    """A stored file or folder: its name, its size, and the time since it last changed."""

    name: str
    size: int
    age_s: float


class Blobs(Protocol):
    """Files and folders by name, each written once and whole. A folder's name has no suffix."""

    def where(self, name: str) -> str:
        """The full name for a message."""

    def exists(self, name: str) -> bool:
        """Whether it exists and is complete."""

    def local(self, name: str) -> Any:
        """A context in which it is available at a local path."""

    def keep(self, name: str, write: Write) -> None:
        """Stores the file that `write` writes, unless it exists."""

    def keep_folder(self, name: str, write: Write) -> None:
        """Stores the folder that `write` makes, unless it exists."""

    def remove_file(self, name: str) -> None:
        """Removes a file, if it is there."""

    def remove_folder(self, name: str) -> None:
        """Removes a folder, if it is there."""

    def kept(self, folder: str) -> list[Kept]:
        """The files and folders within a folder, whole or not, by name."""


def blobs_of(home: Home) -> Blobs:
    """The place where a home keeps its recordings; raises Unusable for an invalid MIMUCAL_STORE."""
    url = environment().store
    return _bucket(url) if url else Folder(home.path)


class Folder:
    """A folder of this machine: files are read where they are."""

    def __init__(self, root: Path) -> None:
        self._root = root

    def where(self, name: str) -> str:
        return str(self._root / name)

    def exists(self, name: str) -> bool:
        return (self._root / name).exists()

    @contextmanager
    def local(self, name: str) -> Iterator[Path]:
        yield self._root / name

    def keep(self, name: str, write: Write) -> None:
        if not self.exists(name):
            with writing_to(self._root / name) as draft:
                write(draft)

    def keep_folder(self, name: str, write: Write) -> None:
        folder = self._root / name
        if not folder.exists():  # then somebody may be faster with the same
            with writing_in_home(folder), suppress(FileExistsError):
                write(folder)

    def remove_file(self, name: str) -> None:
        with _allowed(self.where(name)):
            (self._root / name).unlink(missing_ok=True)

    def remove_folder(self, name: str) -> None:
        with _allowed(self.where(name)), suppress(FileNotFoundError):
            shutil.rmtree(self._root / name)

    def kept(self, folder: str) -> list[Kept]:
        found = []
        for path in sorted((self._root / folder).glob("*")):
            within = [each for each in path.rglob("*") if each.is_file()] or [path]
            with suppress(FileNotFoundError):  # gone meanwhile
                about = [each.stat() for each in within]
                age_s = time.time() - max(each.st_mtime for each in about)
                size = sum(each.st_size for each in about)
                found.append(Kept(f"{folder}/{path.name}", size, age_s))
        return found


class Bucket:
    """A bucket: what is read is fetched first, what is written is uploaded when it is whole."""

    def __init__(self, system: Any, root: str) -> None:
        self._system = system
        self._root = root

    def where(self, name: str) -> str:
        return f"s3://{self._root}/{name}"

    def exists(self, name: str) -> bool:
        whole = not Path(name).suffix and self._is_object(f"{name}/{WHOLE_LAST}")
        return whole or self._is_object(name)

    @contextmanager
    def local(self, name: str) -> Iterator[Path]:
        with TemporaryDirectory(prefix="mimucal-") as folder:
            target = Path(folder) / Path(name).name
            if target.suffix or not self._download_folder(name, target):
                self._download(name, target)
            yield target

    def keep(self, name: str, write: Write) -> None:
        if not self.exists(name):
            with TemporaryDirectory(prefix="mimucal-") as folder:
                path = Path(folder) / "file"
                write(path)
                self._upload(path, name)

    def keep_folder(self, name: str, write: Write) -> None:
        if self.exists(name):
            return
        with TemporaryDirectory(prefix="mimucal-") as folder:
            made = Path(folder) / "folder"
            write(made)
            for path in sorted(made.iterdir(), key=lambda path: path.name == WHOLE_LAST):
                self._upload(path, f"{name}/{path.name}")

    def remove_file(self, name: str) -> None:
        with _explained(self.where(name)), suppress(FileNotFoundError):
            self._system.delete_file(f"{self._root}/{name}")

    def remove_folder(self, name: str) -> None:
        with _explained(self.where(name)), suppress(FileNotFoundError):
            self._system.delete_dir(f"{self._root}/{name}")

    def kept(self, folder: str) -> list[Kept]:
        found: dict[str, Kept] = {}
        for info in self._files(folder):
            name = "/".join(info.path.removeprefix(f"{self._root}/").split("/")[:2])
            before = found.get(name, Kept(name, 0, float("inf")))
            age_s = min(before.age_s, time.time() - info.mtime.timestamp())
            found[name] = Kept(name, before.size + info.size, age_s)
        return [found[name] for name in sorted(found)]

    def _files(self, folder: str) -> list[Any]:
        """Every object within a folder, however deep."""
        from pyarrow.fs import FileSelector, FileType

        with _explained(self.where(folder)):
            within = FileSelector(f"{self._root}/{folder}", allow_not_found=True, recursive=True)
            found = self._system.get_file_info(within)
        return [info for info in found if info.type == FileType.File]

    def _is_object(self, name: str) -> bool:
        from pyarrow.fs import FileType

        with _explained(self.where(name)):
            info = self._system.get_file_info(f"{self._root}/{name}")
        return bool(info.type == FileType.File)

    def _download_folder(self, name: str, target: Path) -> bool:
        """Fetches what a folder's manifest names, which saves a listing; False without a manifest.

        Raises ValueError for a manifest that names none of the folder's own files.
        """
        target.mkdir()
        if not self._download(f"{name}/{WHOLE_LAST}", target / WHOLE_LAST):
            target.rmdir()
            return False
        for each in _named_in(target / WHOLE_LAST):
            self._download(f"{name}/{each}", target / each)
        return True

    def _download(self, name: str, target: Path) -> bool:
        """Fetches an object; False if there is none."""
        with _explained(self.where(name)):
            try:
                source = self._system.open_input_file(f"{self._root}/{name}")
            except FileNotFoundError:
                return False
            with source, target.open("wb") as copy:
                while len(part := source.read_buffer(REQUESTED)):
                    copy.write(part)
        return True

    def _upload(self, path: Path, name: str) -> None:
        """One object appears whole, when its last part was sent."""
        with (
            _explained(self.where(name)),
            path.open("rb") as source,
            self._system.open_output_stream(f"{self._root}/{name}") as target,
        ):
            shutil.copyfileobj(source, target, 8 * 2**20)


def _named_in(manifest: Path) -> list[str]:
    """The files of its folder that a manifest names: plain names, never a path to elsewhere."""
    try:
        names = [str(each) for each in json.loads(manifest.read_bytes())["streams"].values()]
    except (ValueError, KeyError, TypeError, AttributeError) as fault:
        raise ValueError(f"{manifest.name} names no files") from fault
    if not all(PLAIN_NAME.fullmatch(each) for each in names):
        raise ValueError(f"{manifest.name} names what is no file of its folder")
    return names


@lru_cache
def _bucket(url: str) -> Bucket:
    from pyarrow.fs import AwsStandardS3RetryStrategy, S3FileSystem

    place, key, secret = login_apart(url)
    parts = urlsplit(place)
    asked = dict(parse_qsl(parts.query))
    root = f"{parts.netloc}{parts.path.rstrip('/')}"
    is_s3 = parts.scheme == "s3" and parts.netloc and asked.keys() <= OPTIONS.keys()
    if not is_s3 or (key is None) != (secret is None):
        raise Unusable(f"MIMUCAL_STORE is {shown(url)}, which cannot be used; {WAY_OUT}.")
    # Recordings are checked against their own digest: the client's check sums would only repeat it.
    os.environ.setdefault("AWS_RESPONSE_CHECKSUM_VALIDATION", "when_required")
    system = S3FileSystem(
        **{OPTIONS[name]: value for name, value in asked.items()},
        access_key=key,
        secret_key=secret,
        request_timeout=REQUEST_S,
        connect_timeout=CONNECT_S,
        retry_strategy=AwsStandardS3RetryStrategy(max_attempts=ATTEMPTS),
    )
    return Bucket(system, root)


@contextmanager
def _allowed(where: str) -> Iterator[None]:
    try:
        yield
    except PermissionError as error:
        raise Unusable(
            f"{where} cannot be deleted ({error.strerror}); grant access to it."
        ) from error


@contextmanager
def _explained(where: str) -> Iterator[None]:
    """Turns a bucket that does not answer, or refuses, into a sentence."""
    try:
        yield
    except OSError as error:
        reason = str(error).splitlines()[0].rstrip(".")[:300]
        raise Unreachable(
            f"{where} cannot be reached ({reason}); see that the bucket is there and that the keys "
            "in the environment may use it, or set MIMUCAL_STORE to another."
        ) from error
