"""`mimucal simulate`: a recording that can be read, imported and explained with."""

import json

import numpy as np
import pytest

from schemas.recording import ACCEL, GYRO
from storage.formats.folder import read_folder


def test_simulation_of_a_clean_plant_reads_what_the_plant_read(
    mimucal, plant_clean, tmp_path
) -> None:
    done = mimucal("simulate", plant_clean, "--out", tmp_path / "sim", "--json")
    assert (done.code, done.json["format"]) == (0, "mimu-simulate/1")
    assert done.json["assumed_ideal"] == []
    simulated, read = read_folder(tmp_path / "sim"), read_folder(plant_clean)
    assert len(simulated.imu) == done.json["rows"]
    miss = simulated.imu.stack(GYRO + ACCEL) - read.imu.stack(GYRO + ACCEL)[-done.json["rows"] :]
    held = [read.imu.rows(s.t_start, s.t_end) for s in read.manifest.segments if s.kind == "static"]
    means = np.array([miss[rows].mean(axis=0) for rows in held])
    assert np.abs(means[:, :3]).max() < 2e-4
    assert np.abs(means[:, 3:]).max() < 5e-3


@pytest.mark.rehearsal
def test_calibration_may_come_from_a_file_or_by_its_id(mimucal, plant_clean, tmp_path) -> None:
    calibration = mimucal("calibrate", plant_clean, "--json")
    file = tmp_path / "result.json"
    document = json.loads(calibration.out)
    document["items"]["gyro_bias"]["value"]["x"] += 1.0
    file.write_text(json.dumps(document), encoding="utf-8")
    (kept,) = mimucal("show", calibration.json["run"], "--json").json["results"]
    for folder, named in (("a", file), ("b", kept["id"])):
        done = mimucal("simulate", plant_clean, "--calibration", named, "--out", tmp_path / folder)
        assert done.code == 0, done.err
    a, b = (read_folder(tmp_path / folder).imu.columns["gyro_x"] for folder in "ab")
    np.testing.assert_allclose(a - b, np.radians(1.0), atol=1e-12)


def test_bad_calibration_is_one_sentence(mimucal, plant_clean, tmp_path) -> None:
    """Not there, not a result, not JSON."""
    order, wrong = tmp_path / "order.toml", tmp_path / "result.json"
    order.write_text('format = "mimu-order/1"\n', encoding="utf-8")
    wrong.write_text("{", encoding="utf-8")
    for named, says in (("nowhere", "no result"), (order, "mimu-order/1"), (wrong, "not JSON")):
        done = mimucal("simulate", plant_clean, "--calibration", named, "--out", tmp_path / "sim")
        assert done.code == 2
        assert done.err.strip().count("\n") == 0
        assert says in done.err
        assert not (tmp_path / "sim").exists()


def test_a_folder_that_is_taken_is_not_written_over(mimucal, plant_clean, tmp_path) -> None:
    (tmp_path / "kept").write_text("mine", encoding="utf-8")
    done = mimucal("simulate", plant_clean, "--out", tmp_path)
    assert done.code == 2
    assert "new folder" in done.err
    assert (tmp_path / "kept").read_text(encoding="utf-8") == "mine"
