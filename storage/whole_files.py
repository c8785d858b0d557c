"""Writes files into the home: complete or not at all, once, read-only."""

import hashlib
import os
import secrets
import shutil
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from schemas.base import Unusable

MAX_TEXT_BYTES = 2**26  # a manifest, a result, a file of limits
MAX_DEPTH = 64  # lists and objects within each other
READ_ONLY, READ_WRITE = 0o444, 0o666
GROUP, OTHERS = 0o070, 0o007


@contextmanager
def drafted(path: Path) -> Iterator[Path]:
    """Gives a hidden name beside `path` for a file or folder; on success it gets the name `path`.

    On any error nothing incomplete remains. Raises FileExistsError for a folder whose name is
    taken; a file is replaced.
    """
    draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        yield draft
        try:
            draft.replace(path)
        except OSError as error:
            if draft.is_dir():
                raise FileExistsError(f"{path} is already there") from error
            raise
    finally:
        if draft.is_dir():
            shutil.rmtree(draft, ignore_errors=True)
        elif os.path.lexists(draft):
            draft.unlink()


@contextmanager
def writing_in_home(path: Path) -> Iterator[None]:
    """Makes the folder of a file first; a disk that refuses raises Unusable with the way out.

    New files there are accessible to those who may use its folder, and to nobody else.
    """
    try:
        make_folder(path.parent)
        is_there = path.exists()
        yield
        if not is_there:
            _share_as_folder(path)
    except OSError as error:
        raise Unusable(
            f"{path} cannot be written ({error.strerror or error}); make room or give rights "
            "there, or set MIMUCAL_HOME to a writable folder."
        ) from error


def make_folder(folder: Path) -> None:
    """Makes a folder and those above it for their owner alone; one that is there stays as it is.

    Where the folder above gives its group more than everybody, the group shares it on purpose, and
    shares what is made there.
    """
    if folder.is_dir():
        return
    make_folder(folder.parent)
    above = folder.parent.stat().st_mode
    shared = above & GROUP if (above & GROUP) >> 3 != above & OTHERS else 0
    with suppress(FileExistsError):
        folder.mkdir(0o700)
        folder.chmod(folder.stat().st_mode & stat.S_ISGID | 0o700 | shared)
    folder.mkdir(exist_ok=True)  # refuses a file of that name


def _share_as_folder(path: Path) -> None:
    """A new file or folder, and the files in it, for those who may use the folder that it is in."""
    rights = _rights(path.parent)
    if path.is_dir():
        path.chmod(path.stat().st_mode & stat.S_ISGID | rights)
        for each in path.iterdir():
            _share_as_folder(each)
    elif path.exists():
        path.chmod((READ_WRITE if path.stat().st_mode & stat.S_IWUSR else READ_ONLY) & rights)


def _rights(folder: Path) -> int:
    return folder.stat().st_mode & 0o777


@contextmanager
def writing_to(path: Path) -> Iterator[Path]:
    """Gives a draft to write; on success it is on the disk, read-only, under `path`.

    Makes the folder first. A disk that refuses raises Unusable.
    """
    with writing_in_home(path):
        with drafted(path) as draft:
            yield draft
            draft.chmod(READ_ONLY & _rights(path.parent))
            to_disk(draft)
        to_disk(path.parent)


@contextmanager
def written_out(path: Path) -> Iterator[Path]:
    """Gives a draft of a file that was asked for outside the home; it appears whole or not at all.

    Makes its folder first. A disk that refuses raises Unusable, and what was there before stays.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with drafted(path) as draft:
            yield draft
    except OSError as error:
        raise Unusable(
            f"{path} cannot be written ({error.strerror or error}); make room or give rights "
            "there, or name another place with --out."
        ) from error


def report_folder(name: str | None) -> Path | None:
    """The folder that --out names, made; Unusable for what cannot become one. None: no report."""
    if name is None:
        return None
    folder = Path(name)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Unusable(
            f"{folder} cannot be made a folder ({error.strerror}); name another with --out."
        ) from error
    return folder


def to_disk(path: Path) -> None:
    """Waits until a file, or the names in a folder, are on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def is_as_kept(path: Path, sha256: str) -> bool:
    """Whether a file still has the SHA-256 that it was kept with; OSError if it is unreadable."""
    with path.open("rb") as opened:
        return hashlib.file_digest(opened, "sha256").hexdigest() == sha256


def check_plain(path: Path) -> None:
    """Raises Unusable for a pipe or a device, which might never end; a missing file is accepted."""
    try:
        is_other = path.exists() and not (path.is_file() or path.is_dir())
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise Unusable(f"{str(path)[:80]} cannot be opened ({why}); give another path.") from error
    if is_other:
        raise Unusable(f"{path} is a pipe or a device, not a file; give a file or a folder.")


def text_bytes(path: Path) -> bytes:
    """The bytes of a text; raises Unusable for what is no plain file or is far too long, and
    OSError for what cannot be read.
    """
    check_plain(path)
    with path.open("rb") as file:
        content = file.read(MAX_TEXT_BYTES + 1)
    if len(content) > MAX_TEXT_BYTES:
        raise Unusable(
            f"{path} has more than {MAX_TEXT_BYTES // 2**20} MB, which no such text has; give "
            "the file that was meant."
        )
    return content


def check_depth(value: object, depth: int = 0) -> None:
    """Raises ValueError for lists and objects that are nested deeper than MAX_DEPTH."""
    if depth > MAX_DEPTH:
        raise ValueError(f"nested more than {MAX_DEPTH} deep")
    if isinstance(value, dict | list):
        for inner in value.values() if isinstance(value, dict) else value:
            check_depth(inner, depth + 1)


# Secrets kept in files: made whole at once, and read only where nobody else can read them.

BYTES = 32  # of a secret that is generated here; as text, two hexadecimal digits each
LEAST = 32  # characters of one that somebody else made
MOST = 4096  # bytes that are read of one
OF_OTHERS = 0o077


def made(path: Path) -> str:
    """The secret of a file, which is made with a random one where there is none yet.

    Whoever is first wins: it appears whole under its name, and is never replaced. Raises Unusable
    as `read`, and where it cannot be written.
    """
    if not os.path.lexists(path):
        draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
        with writing_in_home(draft):  # which is lost then: only new files get the home's sharing
            file = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
            try:
                with open(file, "w", encoding="ascii") as out:
                    out.write(secrets.token_hex(BYTES))
                with suppress(FileExistsError):
                    os.link(draft, path)
            finally:
                draft.unlink()
    return read(path)


def read(path: Path) -> str:
    """The secret of a file.

    Raises Unusable for one that is missing, a link, another user's, readable by others, or short.
    """
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK), "rb") as file:
            about, content = os.fstat(file.fileno()), file.read(MOST)
    except OSError as error:
        raise Unusable(
            f"{path} cannot be read ({error.strerror}); it is a file of its own, which the account "
            "that runs mimucal owns and may read."
        ) from error
    if about.st_uid not in (os.geteuid(), 0):
        raise Unusable(
            f"{path} belongs to another user (uid {about.st_uid}), who knows what it holds; remove "
            "it, and let the account that runs mimucal make it."
        )
    if not stat.S_ISREG(about.st_mode) or about.st_mode & OF_OTHERS:
        raise Unusable(
            f"{path} can be read by others ({stat.filemode(about.st_mode)}), so it is no secret; "
            "remove it, and write it anew with chmod 600."
        )
    secret = content.decode("ascii", "replace").strip()
    if len(secret) < LEAST:
        raise Unusable(
            f"{path} holds {len(secret)} characters; write at least {LEAST} random ones "
            "(openssl rand -hex 32)."
        )
    return secret
