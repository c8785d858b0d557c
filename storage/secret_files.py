"""Secrets kept in files: made whole at once, and read only where nobody else can read them."""

import os
import secrets
import stat
from contextlib import suppress
from pathlib import Path

from schemas.base import Unusable
from storage.whole_files import writing_in_home

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
