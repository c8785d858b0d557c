"""What lies beside the project in ../shared; a test that asks for it is skipped where it is not."""

import shutil
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "shared"
ABSENT = " is not here"


def shared_path(name: str) -> Path:
    """A path in ../shared, as “data/real/ferraris_session”.

    Skips the test that asks for it in a clone without ../shared beside it; `tests/conftest.py`
    counts those in the closing lines. With ../shared there, a file that is missing is a failure.
    """
    if not FOLDER.exists():
        folder = "/".join(Path(name).parts[:2])
        pytest.skip(f"../shared/{folder}{ABSENT}")
    return FOLDER / name


def chromium() -> str:
    """The browser that Debian's package chromium installs; skips the test where none is."""
    path = shutil.which("chromium")
    if path is None:
        pytest.skip(f"chromium{ABSENT} (apt-get install chromium)")
    return path
