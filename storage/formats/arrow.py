"""float64 columns of pyarrow as numpy arrays; pyarrow's own way imports pandas: half a second."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pyarrow as pa


def to_numpy(column: "pa.ChunkedArray") -> np.ndarray:
    """(n,) float64, NaN where the column is null; without a copy where it has one chunk."""
    if column.null_count:
        import pyarrow.compute as pc  # late: what was kept has no nulls

        column = pc.fill_null(column, from_numpy(np.array([np.nan]))[0])
    parts = [np.from_dlpack(chunk) for chunk in column.chunks]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def from_numpy(values: np.ndarray) -> "pa.Array":
    """The values (n,) as float64 without nulls."""
    import pyarrow as pa

    data = pa.py_buffer(np.ascontiguousarray(values, dtype=np.float64))
    return pa.Array.from_buffers(pa.float64(), len(values), [None, data])
