"""A home with a run, a result, an issued certificate, settings and a key."""

from collections.abc import Callable
from pathlib import Path

import pytest

from storage.catalogue import audit_trail, results, runs
from storage.catalogue.database import changing
from storage.home import Home
from tests.keep import keep
from tests.storage.small import calibrated, certified, small

Fill = Callable[[Home], Home]


@pytest.fixture
def filled() -> Fill:
    """Fills a home."""

    def fill(home: Home) -> Home:
        recording = small()
        run = runs.add(recording, home)[0]
        runs.add(small(1.0, serial="2"), home)
        for bias in (0.25, 0.5, 0.125):
            results.save(calibrated(run, bias), home)
        keep(certified(recording, calibrated(run, 0.125), "A-1"), home)
        with changing(home) as connection:
            audit_trail.add(connection, "李", "add user", "赵", role="viewer")
        home.tolerances.mkdir()
        (home.tolerances / "U.toml").write_text('format = "mimu-tolerance/1"\n')
        (home.path / "orders.key").write_bytes(b"key")
        (home.path / "orders.key").chmod(0o600)
        return home

    return fill


@pytest.fixture
def backups(tmp_path) -> Path:
    """A folder for backups, which is not there yet."""
    return tmp_path / "backups"
