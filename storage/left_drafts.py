"""Draft files left behind by a process that ended before the catalogue knew of them."""

import re
import time
from collections.abc import Collection, Iterator
from pathlib import Path

from storage.home import Home

BY_NAME = re.compile(r"draft-.+\.[0-9a-f]{12}\.(pdf|xml|json)|\..+\.part")
AGE_S = 3600.0  # a newer one may belong to a draft that is being stored


def is_of_draft(path: Path) -> bool:
    """Whether a file among the certificates has the name of a draft's, whole or half-written."""
    return BY_NAME.fullmatch(path.name) is not None


def left_drafts(home: Home, known: Collection[Path]) -> Iterator[Path]:
    """Files of drafts that are not known, an hour after they were written."""
    for path in sorted(home.certificates.glob("*")):
        if is_of_draft(path) and path not in known and age_s(path) > AGE_S:
            yield path


def age_s(path: Path) -> float:
    """Seconds since a file was written."""
    return time.time() - path.stat().st_mtime
