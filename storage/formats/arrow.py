"""float64 columns of pyarrow as numpy has them; pyarrow's own ways import pandas: half a second."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pyarrow as pa


def to_numpy(column: "pa.ChunkedArray") -> np.ndarray:
    """(n,) float64, NaN where the column is null; without a copy where it has one chunk."""
    import pyarrow as pa
    import pyarrow.compute as pc

    parts = [
        np.frombuffer(chunk.buffers()[1], np.float64)[chunk.offset : chunk.offset + len(chunk)]
        for chunk in column.chunks
    ]
    values = parts[0] if len(parts) == 1 else np.concatenate(parts)
    if not column.null_count:
        return values
    is_null = to_numpy(pc.cast(pc.is_null(column), pa.float64()))
    return np.where(is_null == 1.0, np.nan, values)


def from_numpy(values: np.ndarray) -> "pa.Array":
    """The values (n,) as float64 without nulls."""
    import pyarrow as pa

    data = pa.py_buffer(np.ascontiguousarray(values, dtype=np.float64))
    return pa.Array.from_buffers(pa.float64(), len(values), [None, data])
