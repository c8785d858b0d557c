"""Recordings from elsewhere: what a path holds, and whether it was imported before."""

import hashlib
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path

from schemas.base import Unusable
from schemas.recording import Manifest, Recording
from storage.formats.convert import Changes, changed, second_of
from storage.formats.folder import read_folder
from storage.formats.logger.read import is_log
from storage.formats.manifest import MANIFEST, check_controls, manifest_of
from storage.formats.mcap.chunks import MAGIC
from storage.formats.mcap.reader import METADATA, SQLITE, SUFFIXES, bag_files, read_mcap
from storage.whole_files import check_plain, text_bytes

KINDS = (".json", ".parquet", ".csv")


def read(
    path: Path,
    *,
    manifest: Path | None = None,
    salvage: bool = False,
    by_log_time: bool = False,
    changes: Changes | None = None,
) -> Recording:
    """Reads a recording from a `mimu-recording/1` folder, an MCAP file or a ROS 2 bag.

    `manifest` is a manifest.json that goes before the one in an MCAP file; `salvage` takes
    what is whole of an MCAP file that is cut off; `by_log_time` stamps a bag's messages when they
    were recorded; `changes` are of its units, axes and label times. Raises Unusable for anything
    else.
    """
    bag = _bag(path)
    if bag:
        given = None if manifest is None else _manifest(manifest)
        named = bag[0] if len(bag) == 1 else path
        recording = read_mcap(
            named, files=bag, manifest=given, salvage=salvage, by_log_time=by_log_time
        )
    elif manifest is None:
        recording = read_folder(path, second_of(changes))
    else:
        raise Unusable(
            f"{path} is a folder with its own {MANIFEST}; correct it there and leave out "
            f"{manifest}."
        )
    fields = recording.manifest.model_dump(mode="json")
    check_controls(fields, f"The manifest of {path}" if manifest is None else str(manifest))
    return changed(recording, changes, is_timed=not bag) if changes else recording


def fingerprint(path: Path) -> str:
    """SHA-256 (hex) of the bytes of a source's files: the same source need not be read twice.

    Raises Unusable for what is no recording.
    """
    hasher = hashlib.sha256()
    for name, file in _files(path):
        with _open(file) as opened:
            hasher.update(f"{name}\0{hashlib.file_digest(opened, 'sha256').hexdigest()}\0".encode())
    return hasher.hexdigest()


def _files(path: Path) -> Iterator[tuple[str, Path]]:
    """The files that make a source, with the names that matter: an MCAP file may be moved."""
    bag = _bag(path)
    for number, file in enumerate(bag):
        yield "mcap" if len(bag) == 1 else f"mcap {number}", file
    if bag:
        return
    for file in sorted(path.rglob("*")):
        if file.is_file() and file.suffix.lower() in KINDS:
            yield file.relative_to(path).as_posix(), file


def _bag(path: Path) -> tuple[Path, ...]:
    """The files of the bag that a path means; none for a `mimu-recording/1` folder."""
    check_plain(path)
    if path.is_dir():
        if (path / MANIFEST).exists():
            return ()
        files = bag_files(path)
        if not files:
            raise Unusable(_no_recording(path))
        return files
    with _open(path) as opened:
        begins = opened.read(len(SQLITE))
    if begins.startswith((MAGIC, SQLITE)) or path.name.lower().endswith(SUFFIXES):
        return (path,)
    if path.name == MANIFEST:
        raise Unusable(f"{path} is the manifest alone; give the folder {path.parent} instead.")
    if is_log(path):
        raise Unusable(
            f"{path} is a logger's table, not a recording; take it in by `mimucal import {path} "
            "--protocol FILE`, and give the run that it prints."
        )
    raise Unusable(
        f"{path} is not a recording: it does not begin as an MCAP file does; give an MCAP file or "
        "a mimu-recording/1 folder."
    )


def _no_recording(path: Path) -> str:
    bags = sorted(file for file in path.iterdir() if file.name.lower().endswith(SUFFIXES))
    if len(bags) > 1:
        return (
            f"{path} holds {len(bags)} files of bags, and neither {MANIFEST} nor {METADATA}; give "
            f"one of them, for example {bags[0]}, or run `ros2 bag reindex {path}`."
        )
    if bags:
        return f"{path} has neither {MANIFEST} nor {METADATA}; give the file {bags[0]} itself."
    return f"{path} holds no recording: {MANIFEST} is missing; give a folder that has one."


def _open(path: Path) -> BufferedReader:
    try:
        return path.open("rb")
    except OSError as error:
        raise _unreadable(path, error) from error


def _manifest(path: Path) -> Manifest:
    try:
        return manifest_of(text_bytes(path), str(path))
    except OSError as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, error: OSError) -> Unusable:
    why = error.strerror
    return Unusable(f"{path} cannot be read ({why}); check that it exists and is readable.")
