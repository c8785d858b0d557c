"""A home that an earlier version left, upgraded: one is kept for each format on disk.

`homes/2026-11-22.tar.xz` was written by the version of that day: an ideal run of JJF 2003, two
results of it and a certificate whose PDF is a line of text.
"""

import tarfile
from collections.abc import Callable
from datetime import date
from pathlib import Path

import numpy as np
import pytest

from schemas.recording import Recording
from storage.backup.upgrade import upgrade
from storage.catalogue import certificates, results, run_index, runs
from storage.formats.mcap.reader import read_mcap
from storage.home import Home
from storage.verify import verify

MADE_AT = 9.8  # m/s², the gravity of that ideal run
HOMES = sorted((Path(__file__).parent / "homes").glob("*.tar.xz"))


@pytest.fixture(params=HOMES, ids=lambda path: path.name)
def earlier(request, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Home:
    monkeypatch.delenv("MIMUCAL_DATABASE", raising=False)
    with tarfile.open(request.param) as archive:
        archive.extractall(tmp_path / "home", filter="data")
    home = Home(tmp_path / "home")
    upgrade(home, "1")
    return home


def test_recording_is_read_from_its_columns_and_from_raw(
    earlier: Home, ideal_run: Callable[..., Recording]
) -> None:
    (run,) = run_index.all_runs(earlier)
    expected = ideal_run(dwell=1.0, gravity=MADE_AT)
    loaded = runs.from_columns(run, earlier)
    assert loaded is not None
    for recording in (loaded, read_mcap(earlier.raw / f"{run.digest}.mcap")):
        assert recording.digest == run.digest
        for name, values in recording.imu.columns.items():
            np.testing.assert_array_equal(values, expected.imu.columns[name])


def test_results_and_certificate_are_read_and_nothing_is_at_fault(earlier: Home) -> None:
    (run,) = run_index.all_runs(earlier)
    first, second = results.of_run(run, earlier)
    assert second.supersedes == first.id
    assert first.calibration.items["gyro_scale_factor"].value["x"] == pytest.approx(1.0, abs=1e-6)
    (entry,) = certificates.register(earlier)
    assert certificates.find(entry.number, earlier).calibration == first.calibration
    assert (entry.number, entry.state) == ("MIMU-2026-0001", "draft")
    assert (
        certificates.due(earlier, date(2030, 1, 2)) == []
    )  # drafts had numbers, and count no more
    assert verify(earlier)[1] == []
