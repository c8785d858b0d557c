"""`mimucal table`: what the store holds, as CSV or Parquet."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from schemas.base import Unusable
from storage.home import home
from storage.whole_files import drafted, writing_in_home

if TYPE_CHECKING:
    import pandas as pd

PARTITIONS = ["station", "month"]


def write_table(what: str, form: str, out: Path | None) -> None:
    """Write a table to a file, to a folder of Parquet files, or to standard output."""
    from storage.dataframes import TABLES

    if what not in TABLES:
        raise Unusable(f"{what!r} is no table; choose one of {', '.join(TABLES)}.")
    if form not in ("csv", "parquet"):
        raise Unusable(f"--as {form}: choose one of csv, parquet")
    if form == "parquet" and out is None and sys.stdout.isatty():
        raise Unusable("--as parquet is no text for a terminal; give a file with --out")
    table = TABLES[what](home())
    if out is None:
        _to_stdout(table, form)
    elif form == "parquet" and not out.suffix:
        _to_folder(table, out)
    else:
        _to_file(table, form, out)


def _to_stdout(table: "pd.DataFrame", form: str) -> None:
    if form == "csv":
        table.to_csv(sys.stdout, index=False, lineterminator="\n")
    else:
        sys.stdout.buffer.write(table.to_parquet(index=False))


def _to_file(table: "pd.DataFrame", form: str, path: Path) -> None:
    with writing_in_home(path), drafted(path) as draft:
        if form == "csv":
            table.to_csv(draft, index=False, lineterminator="\n")
        else:
            table.to_parquet(draft, index=False)


def _to_folder(table: "pd.DataFrame", folder: Path) -> None:
    """A file for each station and month of recording, as pyarrow, duckdb and Spark read them."""
    month = table["recorded_on"].map(lambda day: f"{day:%Y-%m}" if day else "unknown")
    try:
        with drafted(folder) as draft:
            table.assign(month=month).to_parquet(draft, index=False, partition_cols=PARTITIONS)
    except FileExistsError as error:
        raise Unusable(f"{folder} is already there; name a new folder with --out.") from error
    except OSError as error:
        raise Unusable(
            f"{folder} cannot be written ({error.strerror}); name another with --out."
        ) from error
