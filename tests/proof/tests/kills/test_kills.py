"""The judge of killed acquisitions: what it notices, and one acquisition that is killed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from schemas.recording import ACCEL, FORMAT, GYRO, Manifest, Recording, Station, Stream, Unit
from storage.formats.mcap.writer import write_mcap
from tests.proof.kills.kill import judged, kill
from tests.proof.kills.tap import Sent

SCALE = np.array([1e-6] * 3 + [1e-5] * 3)
ROWS = 1000
FIRST = 40  # frames before the run
COUNTS = np.random.default_rng(1).integers(-90_000, 90_000, (ROWS, 6))
SENT = Sent(np.arange(ROWS) / 100, np.arange(ROWS) * 10_000 + 7, COUNTS)
MOMENTS = (0.5, 9.99)


def saved(folder: Path, rows: np.ndarray) -> None:
    """A file with these of the frames."""
    values = dict(zip(GYRO + ACCEL, (COUNTS[rows] * SCALE).T, strict=True))
    manifest = Manifest(
        format=FORMAT,
        recording_id="killed",
        unit=Unit(manufacturer="M", model="U", serial="1"),
        station=Station(id="T1"),
        acquired_at="2026-03-01T08:30:00+00:00",
    )
    imu = Stream(SENT.stamps[rows] / 1e6, values)
    (folder / "acquiring").mkdir()
    write_mcap(Recording(manifest, imu), folder / "acquiring" / "raw.mcap")


def test_all_but_the_last_moment_is_within_the_bound(tmp_path: Path) -> None:
    saved(tmp_path, np.arange(FIRST, 850))
    verdict = judged(1, 1.0, tmp_path, SENT, MOMENTS, SCALE)
    assert verdict.faults == ()
    assert verdict.recovered == 850 - FIRST
    assert verdict.lost_s == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("rows", "sent", "fault"),
    [
        (np.arange(FIRST, 750), SENT, "before the kill are lost"),
        (np.delete(np.arange(FIRST, 900), 300), SENT, "not those that were sent"),
        (np.arange(FIRST, 900), replace(SENT, counts=COUNTS + 1), "was never sent"),
        (np.arange(FIRST, 900), replace(SENT, stamps=SENT.stamps * 2), "times are not"),
    ],
)
def test_what_is_not_as_it_was_sent_is_noticed(
    rows: np.ndarray, sent: Sent, fault: str, tmp_path: Path
) -> None:
    saved(tmp_path, rows)
    verdict = judged(1, 1.0, tmp_path, sent, MOMENTS, SCALE)
    assert any(fault in each for each in verdict.faults)


@pytest.mark.rehearsal
@pytest.mark.real_time
def test_a_killed_acquisition_keeps_what_was_sent(tmp_path: Path) -> None:
    verdict = kill(2, tmp_path / "killed")
    assert verdict.faults == ()
    assert verdict.recovered > 0
