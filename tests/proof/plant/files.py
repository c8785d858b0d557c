"""A simulated recording as files: what is handed out, and apart from it what is sealed."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from schemas.recording import ACCEL, GYRO, Recording


def write(recording: Recording, folder: Path) -> None:
    """Writes manifest.json and the streams; nothing of the truth."""
    folder.mkdir(parents=True, exist_ok=True)
    manifest = recording.manifest.model_dump(mode="json", exclude_none=True)
    _write_json(manifest, folder / "manifest.json")
    for name, stream in recording.streams().items():
        pd.DataFrame({"t": stream.t, **stream.columns}).to_parquet(
            folder / f"{name}.parquet", index=False
        )


def seal(recording: Recording, declared: dict[str, Any], truth: np.ndarray, folder: Path) -> None:
    """Writes truth.json and truth.parquet to another place.

    declared: what truth.json says. truth: (n, 6), the noise-free channels at the recording's rows.
    """
    folder.mkdir(parents=True, exist_ok=True)
    _write_json(declared, folder / "truth.json")
    columns = {"t": recording.imu.t}
    columns |= dict(zip(GYRO + ACCEL, truth.T, strict=True))
    pd.DataFrame(columns).to_parquet(folder / "truth.parquet", index=False)


def _write_json(response: object, path: Path) -> None:
    path.write_text(json.dumps(response, indent=1, ensure_ascii=False), encoding="utf-8")
