"""An S3 server whose objects are the files of a folder: `python -m tests.proof.factory.bucket`.

FOLDER EVERY PAUSE_S [PORT]: each so-manieth request is answered with 500, each after a pause.
Prints what MIMUCAL_STORE is to be, and serves until its standard input ends.
"""

import os
import re
import sys
from collections.abc import Iterator, MutableMapping
from pathlib import Path

from tests.storage.s3_server import Handler, Store, serving

BUCKET = "lab/mimu/"


class Files(MutableMapping[str, bytes]):
    """The files of a folder by the keys of their objects."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def path(self, key: str) -> Path:
        return self._folder / key.removeprefix(BUCKET)

    def __getitem__(self, key: str) -> bytes:
        try:
            return self.path(key).read_bytes()
        except OSError as error:
            raise KeyError(key) from error

    def __setitem__(self, key: str, data: bytes) -> None:
        self.path(key).parent.mkdir(parents=True, exist_ok=True)
        self.path(key).write_bytes(data)

    def __delitem__(self, key: str) -> None:
        self.path(key).unlink(missing_ok=True)

    def __iter__(self) -> Iterator[str]:
        return self.below("")

    def below(self, prefix: str) -> Iterator[str]:
        """The keys that begin with a prefix, which ends a folder's name or is empty."""
        for path in self.path(prefix).rglob("*"):
            if path.is_file():
                yield BUCKET + path.relative_to(self._folder).as_posix()

    def __len__(self) -> int:
        return sum(1 for _ in self)


class FileHandler(Handler):
    """Sends files from the disk as the system does it, without a copy in Python."""

    files: Files

    def _get(self) -> None:
        path = self.files.path(self.key)
        if "list-type" in self.asked or not path.is_file():
            super()._get()
            return
        with path.open("rb") as opened:
            about = os.fstat(opened.fileno())
            first, last, code = 0, about.st_size - 1, 200
            ranged = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range") or "")
            if ranged and self.command == "GET":
                first, code = int(ranged[1]), 206
                last = min(int(ranged[2] or last), last)
            self.send_response(code)
            self.send_header("ETag", f'"{about.st_mtime_ns:x}"')
            self.send_header("Last-Modified", self.date_time_string(int(about.st_mtime)))
            self.send_header("Content-Length", str(last - first + 1))
            if code == 206:
                self.send_header("Content-Range", f"bytes {first}-{last}/{about.st_size}")
            self.end_headers()
            if self.command == "GET":
                self.wfile.flush()
                while first <= last:
                    first += os.sendfile(
                        self.connection.fileno(), opened.fileno(), first, last - first + 1
                    )

    def _keys(self, prefix: str) -> list[str]:
        return sorted(self.files.below(prefix))


def main(folder: Path, every: int, pause_s: float, port: int = 0) -> None:
    store, files = Store(every, pause_s), Files(folder)
    store.objects = files
    with serving(store, type("Here", (FileHandler,), {"files": files}), port) as url:
        print(url, flush=True)
        sys.stdin.read()


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]), *map(int, sys.argv[4:]))
