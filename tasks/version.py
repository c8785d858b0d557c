"""Which code made a result: the release and a hash of the source itself."""

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

ROOMS = ("flows", "tasks", "schemas", "storage")


@cache
def code_version() -> str:
    """Release and the first 12 digits of the SHA-256 over every source file, «0.1.0+9f3c…».

    Two programs with the same text here give the same results, bit for bit, on one machine.
    """
    root = Path(__file__).parent.parent
    digest = hashlib.sha256()
    for room in ROOMS:
        for source in sorted((root / room).rglob("*.py")):
            digest.update(source.relative_to(root).as_posix().encode())
            digest.update(source.read_bytes())
    return f"{version('mimucal')}+{digest.hexdigest()[:12]}"
