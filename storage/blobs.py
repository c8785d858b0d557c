"""Where raw recordings and their columns are kept: a folder, or a bucket that speaks S3.

MIMUCAL_STORE names the bucket as s3://BUCKET/PREFIX, with `endpoint`, `scheme` and `region` behind
a question mark where it is not AWS; without it they are in the home. Keys come from the
environment, as AWS names them.
"""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol
from urllib.parse import parse_qsl, urlsplit

from schemas.base import Unusable
from storage.home import Home
from storage.whole_files import writing_in_home, writing_to

WAY_OUT = "give it as s3://BUCKET/PREFIX, with ?endpoint=HOST:PORT&scheme=http where it is not AWS"
OPTIONS = {"endpoint": "endpoint_override", "scheme": "scheme", "region": "region"}
ATTEMPTS = 8  # of each request, with growing pauses: about half a minute
REQUEST_S, CONNECT_S = 60.0, 10.0
WHOLE_LAST = "manifest.json"  # uploaded after the rest: a folder that has it is whole

Write = Callable[[Path], None]


class Unreachable(Unusable):
    """The bucket does not answer, or refuses: the same again may succeed."""


class Blobs(Protocol):
    """Files and folders by name, each written once and whole."""

    def where(self, name: str) -> str:
        """What a sentence calls it."""

    def exists(self, name: str) -> bool:
        """Whether it is there, whole."""

    def local(self, name: str) -> Any:
        """A context in which it is at a local path."""

    def keep(self, name: str, write: Write) -> None:
        """Keeps the file that `write` writes, unless it is there."""

    def keep_folder(self, name: str, write: Write) -> None:
        """Keeps the folder that `write` makes, unless it is there."""

    def remove_folder(self, name: str) -> None:
        """Removes a folder, if it is there."""


def blobs_of(home: Home) -> Blobs:
    """Where a home keeps its recordings; raises Unusable for a MIMUCAL_STORE that is no bucket."""
    url = os.environ.get("MIMUCAL_STORE")
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

    def remove_folder(self, name: str) -> None:
        shutil.rmtree(self._root / name, ignore_errors=True)


class Bucket:
    """A bucket: what is read is fetched first, what is written is uploaded when it is whole."""

    def __init__(self, system: Any, root: str) -> None:
        self._system = system
        self._root = root

    def where(self, name: str) -> str:
        return f"s3://{self._root}/{name}"

    def exists(self, name: str) -> bool:
        from pyarrow.fs import FileType

        with _explained(self.where(name)):
            whole = name if Path(name).suffix else f"{name}/{WHOLE_LAST}"
            info = self._system.get_file_info(f"{self._root}/{whole}")
        return bool(info.type == FileType.File)

    @contextmanager
    def local(self, name: str) -> Iterator[Path]:
        from pyarrow.fs import LocalFileSystem, copy_files

        with TemporaryDirectory(prefix="mimucal-") as folder:
            target = Path(folder) / Path(name).name
            if self.exists(name):
                if not target.suffix:
                    target.mkdir()
                with _explained(self.where(name)):
                    copy_files(
                        f"{self._root}/{name}", str(target),
                        source_filesystem=self._system, destination_filesystem=LocalFileSystem(),
                    )  # fmt: skip
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

    def remove_folder(self, name: str) -> None:
        from pyarrow.fs import FileSelector

        with _explained(self.where(name)):
            within = FileSelector(f"{self._root}/{name}", allow_not_found=True)
            for info in self._system.get_file_info(within):
                self._system.delete_file(info.path)

    def _upload(self, path: Path, name: str) -> None:
        """One object appears whole, when its last part was sent."""
        with (
            _explained(self.where(name)),
            path.open("rb") as source,
            self._system.open_output_stream(f"{self._root}/{name}") as target,
        ):
            shutil.copyfileobj(source, target, 8 * 2**20)


@lru_cache
def _bucket(url: str) -> Bucket:
    from pyarrow.fs import AwsStandardS3RetryStrategy, S3FileSystem

    parts = urlsplit(url)
    asked = dict(parse_qsl(parts.query))
    root = f"{parts.netloc}{parts.path.rstrip('/')}"
    if parts.scheme != "s3" or not parts.netloc or not asked.keys() <= OPTIONS.keys():
        raise Unusable(f"MIMUCAL_STORE is {url!r}, which cannot be used; {WAY_OUT}.")
    system = S3FileSystem(
        **{OPTIONS[name]: value for name, value in asked.items()},
        request_timeout=REQUEST_S,
        connect_timeout=CONNECT_S,
        retry_strategy=AwsStandardS3RetryStrategy(max_attempts=ATTEMPTS),
    )
    return Bucket(system, root)


@contextmanager
def _explained(where: str) -> Iterator[None]:
    """Turns a bucket that does not answer, or refuses, into a sentence."""
    try:
        yield
    except OSError as error:
        reason = str(error).splitlines()[0].rstrip(".")[:300]
        raise Unreachable(
            f"{where} cannot be reached ({reason}); see that the bucket is there and that the keys "
            "in the environment may use it, or let MIMUCAL_STORE name another."
        ) from error
