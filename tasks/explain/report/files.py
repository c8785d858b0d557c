"""Files that appear whole or not at all."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from schemas.base import Unusable
from tasks.explain.channels import CHANNELS
from tasks.explain.explanation import Explanation


def appear(folder: Path, name: str, content: bytes) -> Path:
    """Writes a file under another name first, then gives it its own; makes the folder.

    Raises Unusable where the disk refuses.
    """
    path, draft = folder / name, folder / f".{name}.part"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        draft.write_bytes(content)
        draft.replace(path)
    except OSError as error:
        raise Unusable(
            f"{path} cannot be written ({error.strerror or error}); name another folder with "
            "--out, or make room and give rights there."
        ) from error
    finally:
        if draft.is_file():
            draft.unlink()
    return path


def prediction(explanation: Explanation) -> bytes:
    """prediction.parquet: t (s), and each channel's nominal and found reading, rad/s and m/s².

    One row for each row of the unit's stream; NaN where the motion is not known.
    """
    columns = {"t": explanation.recording.imu.t}
    for i, channel in enumerate(CHANNELS):
        columns[f"{channel}_nominal"] = explanation.nominal[:, i]
        columns[f"{channel}_found"] = explanation.found[:, i]
    arrays = {name: np.ascontiguousarray(each, float) for name, each in columns.items()}
    sink = pa.BufferOutputStream()
    pq.write_table(pa.table(arrays), sink, compression="zstd")
    return bytes(sink.getvalue().to_pybytes())
