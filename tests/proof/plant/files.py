"""A simulated recording as files: what is handed out, and apart from it what is sealed."""

import json
from pathlib import Path

import numpy as np
import pandas as pd

from schemas.recording import ACCEL, GYRO
from tests.proof.plant.simulate import Simulated


def write(simulated: Simulated, folder: Path) -> None:
    """Writes manifest.json and the streams; nothing of the truth."""
    folder.mkdir(parents=True, exist_ok=True)
    manifest = simulated.recording.manifest.model_dump(mode="json", exclude_none=True)
    _write_json(manifest, folder / "manifest.json")
    for name, stream in simulated.recording.streams().items():
        pd.DataFrame({"t": stream.t, **stream.columns}).to_parquet(
            folder / f"{name}.parquet", index=False
        )


def seal(simulated: Simulated, folder: Path) -> None:
    """Writes truth.json and truth.parquet (t and the six noise-free channels) to another place."""
    folder.mkdir(parents=True, exist_ok=True)
    _write_json(simulated.sealed, folder / "truth.json")
    columns = {"t": simulated.recording.imu.t}
    columns |= dict(zip(GYRO + ACCEL, np.asarray(simulated.truth).T, strict=True))
    pd.DataFrame(columns).to_parquet(folder / "truth.parquet", index=False)


def _write_json(said: object, path: Path) -> None:
    path.write_text(json.dumps(said, indent=1, ensure_ascii=False), encoding="utf-8")
