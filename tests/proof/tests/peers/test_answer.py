"""What the blind process writes."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from schemas.recording import Recording
from tests.proof.peers.answer import PEERS, answer_peers
from tests.proof.peers.blocks import block_numbers
from tests.proof.plant.simulate import Simulated


def test_answers_and_predictions_are_written(bent: Simulated, tmp_path: Path) -> None:
    answer_peers(bent.recording, tmp_path / "0001")
    response = json.loads((tmp_path / "0001/peers.json").read_text())
    assert list(response["peers"]) == list(PEERS)
    assert all(one["detected"] and one["failed"] is None for one in response["peers"].values())
    assert response["peers"]["stepwise_bic"]["names"][0] == "gyro_scale_nonlinearity"
    assert response["peers"]["residual_threshold"]["located"][0]["segments"]
    kept = pq.read_table(tmp_path / "0001/peers.parquet")
    assert len(kept) == block_numbers(bent.recording.imu.t)[-1] + 1
    assert {f"gyro_z_{name}" for name in ("nominal", "stepwise_bic", "sindy")} <= {
        *kept.column_names
    }
    assert not [name for name in kept.column_names if name.endswith("residual_threshold")]


def test_failure_is_an_answer(clean: Recording, tmp_path: Path) -> None:
    columns = {name: series for name, series in clean.imu.columns.items() if name[0] not in "ag"}
    columns["spare"] = np.zeros(len(clean.imu.t))
    answer_peers(replace(clean, imu=replace(clean.imu, columns=columns)), tmp_path)
    response = json.loads((tmp_path / "peers.json").read_text())
    assert "no gyro_* or accel_* columns" in response["failed"]
    assert all("Unusable" in one["failed"] for one in response["peers"].values())
    assert not (tmp_path / "peers.parquet").exists()
