"""`mimucal table`: what the store holds, as CSV or Parquet."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from schemas.base import Unusable
from storage.dataframes import TABLES, records, written
from storage.home import home
from storage.whole_files import drafted, written_out

if TYPE_CHECKING:
    import pandas as pd

PARTITIONS = ["station", "month"]


def print_table(what: str, form: str, out: Path | None) -> None:
    """Write a table as `write_table` does, and say so in one JSON document; without a file the
    document has the rows themselves.
    """
    if out is None and form != "csv":
        raise Unusable(f"--json shows no {form}; leave --as out, or give a file with --out")
    if out is not None or what not in TABLES:
        write_table(what, form, out)
        content: dict[str, Any] = {"as": form, "path": str(out)}
    else:
        content = {"rows": records(what, home())}
    document = {"format": "mimu-table/1", "table": what, **content}
    print(json.dumps(document, ensure_ascii=False, indent=1, default=str))


def write_table(what: str, form: str, out: Path | None) -> None:
    """Write a table to a file, to a folder of Parquet files, or to standard output."""
    if what not in TABLES:
        raise Unusable(f"{what!r} is not a table; choose one of {', '.join(TABLES)}.")
    if form not in ("csv", "parquet"):
        raise Unusable(f"--as {form}: choose one of csv, parquet")
    if form == "parquet" and out is None and sys.stdout.isatty():
        raise Unusable("--as parquet cannot be shown in a terminal; give a file with --out")
    if form == "csv" and out is None:
        written(what, home(), sys.stdout)
    elif form == "csv" and out is not None:
        with written_out(out) as draft, draft.open("w", encoding="utf-8", newline="") as file:
            written(what, home(), file)
    else:
        _to_parquet(TABLES[what](home()), out)


def _to_parquet(table: "pd.DataFrame", out: Path | None) -> None:
    if out is None:
        sys.stdout.buffer.write(table.to_parquet(index=False))
    elif not out.suffix:
        _to_folder(table, out)
    else:
        with written_out(out) as draft:
            table.to_parquet(draft, index=False)


def _to_folder(table: "pd.DataFrame", folder: Path) -> None:
    """One file for each station and month of recording, as pyarrow, duckdb and Spark read them."""
    month = table["recorded_on"].map(lambda day: f"{day:%Y-%m}" if day else "unknown")
    try:
        with drafted(folder) as draft:
            draft.mkdir(parents=True)  # of no rows no file is written
            table.assign(month=month).to_parquet(draft, index=False, partition_cols=PARTITIONS)
    except FileExistsError as error:
        raise Unusable(f"{folder} is already there; name a new folder with --out.") from error
    except OSError as error:
        raise Unusable(
            f"{folder} cannot be written ({error.strerror}); name another with --out."
        ) from error
