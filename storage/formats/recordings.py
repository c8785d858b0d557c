"""Recordings from elsewhere: what a path holds, and whether it was imported before."""

import hashlib
from collections.abc import Iterator
from io import BufferedReader
from pathlib import Path

from schemas.base import Unusable
from schemas.recording import Manifest, Recording
from storage.formats.folder import read_folder
from storage.formats.manifest import MANIFEST, check_controls, manifest_of
from storage.formats.mcap.chunk_writer import MAGIC
from storage.formats.mcap.reader import read_mcap
from storage.whole_files import check_plain, text_bytes

BAG = "metadata.yaml"  # beside the MCAP file of a rosbag2 folder
KINDS = (".json", ".parquet", ".csv")


def read(path: Path, *, manifest: Path | None = None, salvage: bool = False) -> Recording:
    """Reads a recording from a `mimu-recording/1` folder, an MCAP file or a rosbag2 folder.

    `manifest` is a manifest.json that goes before the one in an MCAP file; `salvage` takes
    what is whole of an MCAP file that is cut off. Raises Unusable for anything else.
    """
    bag = _mcap(path)
    if bag is not None:
        given = None if manifest is None else _manifest(manifest)
        recording = read_mcap(bag, manifest=given, salvage=salvage)
    elif manifest is None:
        recording = read_folder(path)
    else:
        raise Unusable(
            f"{path} is a folder with its own {MANIFEST}; correct it there and leave out "
            f"{manifest}."
        )
    fields = recording.manifest.model_dump(mode="json")
    check_controls(fields, f"The manifest of {path}" if manifest is None else str(manifest))
    return recording


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
    bag = _mcap(path)
    if bag is not None:
        yield "mcap", bag
        return
    for file in sorted(path.rglob("*")):
        if file.is_file() and file.suffix.lower() in KINDS:
            yield file.relative_to(path).as_posix(), file


def _mcap(path: Path) -> Path | None:
    """The MCAP file that a path means; None for a `mimu-recording/1` folder."""
    check_plain(path)
    if path.is_dir():
        if (path / MANIFEST).exists():
            return None
        bags = sorted(path.glob("*.mcap"))
        if len(bags) == 1 and (path / BAG).exists():
            return bags[0]
        raise Unusable(_no_recording(path, bags))
    with _open(path) as opened:
        begins = opened.read(len(MAGIC))
    if begins == MAGIC or path.suffix.lower() == ".mcap":
        return path
    if path.name == MANIFEST:
        raise Unusable(f"{path} is the manifest alone; give the folder {path.parent} instead.")
    raise Unusable(
        f"{path} is not a recording: it does not begin as an MCAP file does; give an MCAP file or "
        "a mimu-recording/1 folder."
    )


def _no_recording(path: Path, bags: list[Path]) -> str:
    if len(bags) > 1:
        return (
            f"{path} holds {len(bags)} MCAP files and no {MANIFEST}; give one of them, "
            f"for example {bags[0]}."
        )
    if bags:
        return f"{path} has neither {MANIFEST} nor {BAG}; give the file {bags[0]} itself."
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
