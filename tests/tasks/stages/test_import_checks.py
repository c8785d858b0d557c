"""What is refused when it comes in: triads that an item lacks; stored runs are not judged again."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from schemas.base import Unusable
from schemas.recording import ACCEL, GYRO, Recording, Stream
from storage.catalogue import runs
from storage.formats import recordings
from storage.formats.mcap.writer import write_mcap
from storage.home import Home
from tasks.stages.import_recording import faults_of, read
from tests.manifests import manifest_of
from tests.tasks.readings.makers.bench import bench
from tests.tasks.readings.makers.recorded import recorded

ROWS = 40
RATE = {"kind": "rate", "axis": "x", "rate_deg_s": 10.0}
Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path) -> Write:
    """Writes a recording whose named columns are null in some rows, with one label each."""

    def build(absent: tuple[str, ...], rows: slice, *labels: dict) -> Path:
        segments = [
            {"name": f"s{k}", "item": "scale_factor", "t_start": 0.0, "t_end": 1.0} | label
            for k, label in enumerate(labels)
        ]
        manifest = manifest_of("triads", segments=segments)
        t = np.arange(ROWS) / 100
        columns = {n: np.sin(t + k) for k, n in enumerate(GYRO + ACCEL)}
        for name in absent:
            columns[name][rows] = np.nan
        path = tmp_path / "triads.mcap"
        write_mcap(Recording(manifest, Stream(t, columns)), path)
        return path

    return build


@pytest.mark.parametrize("stated", ["2026-13-45T08:00:00Z", "02.03.2026", "yesterday", 5])
def test_a_day_that_no_recall_would_find_is_refused(tmp_path, stated):
    manifest = manifest_of("day", acquired_at=stated)
    t = np.arange(ROWS) / 100
    path = tmp_path / "day.mcap"
    write_mcap(Recording(manifest, Stream(t, {name: np.sin(t) for name in GYRO + ACCEL})), path)
    with pytest.raises(Unusable, match=f"acquired_at .*{stated}.*ISO 8601; write it as"):
        read(path)


@pytest.mark.parametrize(
    ("absent", "label", "words"),
    [
        (GYRO, RATE, ("scale_factor", "gyro_*", "1 segments")),
        (ACCEL, {"item": "rate_sensitivity", "kind": "static"}, ("rate_sensitivity", "accel_*")),
    ],
)
def test_item_without_its_triad_is_refused_with_the_path(write, absent, label, words):
    path = write(absent, slice(None), label)
    with pytest.raises(Unusable) as refusal:
        read(path)
    assert all(word in str(refusal.value) for word in (*words, str(path)))


def test_item_with_one_segment_that_serves_is_taken(write):
    path = write(GYRO, slice(0, 8), RATE | {"t_end": 0.05}, RATE | {"t_start": 0.1})
    assert read(path).manifest.segments


@pytest.mark.parametrize(
    ("factors", "unit"), [((180.0 / np.pi, 1.0), "gyro=deg/s"), ((1.0, 1.0 / 9.80665), "accel=g")]
)
def test_a_unit_that_is_mixed_up_is_refused_with_the_one_it_looks_like(tmp_path, factors, unit):
    made = bench(3, hertz=25.0, dwell=4.0, rates=(40.0,), turns=(0.0,))
    write_mcap(recorded(made), tmp_path / "right.mcap")
    assert read(tmp_path / "right.mcap").manifest.segments
    made.gyro, made.accel = made.gyro * factors[0], made.accel * factors[1]
    write_mcap(recorded(made), tmp_path / "wrong.mcap")
    with pytest.raises(Unusable, match=f"import them with --units {unit}"):
        read(tmp_path / "wrong.mcap")


def test_verifying_a_path_finds_what_an_import_would_refuse(write, tmp_path):
    (fault,) = faults_of(write(GYRO, slice(None), RATE))
    assert "gyro_*" in fault.why
    (missing,) = faults_of(tmp_path / "none")
    assert missing.what.endswith("none")
    assert faults_of(write((), slice(0), RATE)) == []


def test_what_is_stored_is_never_judged_again(write, tmp_path):
    home = Home(tmp_path / "home")
    run, _ = runs.add(recordings.read(write(GYRO, slice(None), RATE)), home)
    assert runs.load(run, home).manifest.recording_id == "triads"
