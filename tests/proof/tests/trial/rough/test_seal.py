"""What is handed out and what is sealed."""

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from storage.formats.folder import read_folder


def test_recording_tells_nothing_of_the_truth_and_can_be_read(sealed_rough: Path) -> None:
    for number in ("0001", "0002"):
        handed = sealed_rough / "recordings" / number
        assert sorted(path.name for path in handed.iterdir()) == [
            "imu.parquet", "manifest.json", "table.parquet"
        ]  # fmt: skip
        assert "bias_step" not in (handed / "manifest.json").read_text()
        assert len(read_folder(handed).imu) > 2000


def test_truth_holds_effects_nuisances_and_where_each_stands(sealed_rough: Path) -> None:
    declared = json.loads((sealed_rough / "sealed/0002/truth.json").read_text())
    trial = json.loads((sealed_rough / "sealed/0002/trial.json").read_text())
    assert [each["called"] for each in declared["effects"]] == ["x_gain_drift", "bias_step_single"]
    assert declared["nuisances"] == {}
    assert trial["z"]["bias_step_single"] == pytest.approx(60.0, rel=0.2)
    rows = pq.read_table(sealed_rough / "sealed/0002/truth.parquet").num_rows
    assert rows == pq.read_table(sealed_rough / "recordings/0002/imu.parquet").num_rows
