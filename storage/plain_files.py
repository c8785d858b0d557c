"""Checks files named by users: regular files, no larger than expected."""

from pathlib import Path

from schemas.base import Unusable

MAX_TEXT_BYTES = 2**26  # a manifest, a result, a file of limits
MAX_DEPTH = 64  # lists and objects within each other


def check_plain(path: Path) -> None:
    """Raises Unusable for a pipe or a device, which might never end; what is not there passes."""
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
