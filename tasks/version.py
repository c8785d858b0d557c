"""The version of the code that made a result: release, source hash and libraries."""

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

ROOMS = ("flows", "tasks", "schemas", "storage")
SOURCES = (".py", ".toml", ".typ", ".ftl")
NUMERICS = ("numpy", "scipy")


@cache
def code_version() -> str:
    """“0.1.0+9f3c… numpy 2.3.0 scipy 1.16.0”: 12 digits of the SHA-256 over every source file.

    Programs with the same text here give the same results, bit for bit, on one machine.
    """
    libraries = " ".join(f"{name} {version(name)}" for name in NUMERICS)
    return f"{version('mimucal')}+{source_digest(Path(__file__).parent.parent)[:12]} {libraries}"


def source_digest(root: Path) -> str:
    """SHA-256 (hex) over name and text of every source, procedure and layout under a root."""
    digest = hashlib.sha256()
    for room in ROOMS:
        for source in sorted((root / room).rglob("*")):
            if source.suffix in SOURCES:
                digest.update(source.relative_to(root).as_posix().encode())
                digest.update(source.read_bytes())
    return digest.hexdigest()
