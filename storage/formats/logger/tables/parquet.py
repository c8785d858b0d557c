"""Apache Parquet."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pandas as pd

SUFFIXES = (".parquet", ".pq")


def read(path: Path) -> "pd.DataFrame":
    """The columns; raises OSError or ValueError for what is no Parquet file."""
    import pandas as pd

    return pd.read_parquet(path)
