"""A logger's table as columns: preamble, header, units and separators found, whatever wrote it."""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from schemas.base import Unusable
from storage.formats.logger.tables import (
    CLOCK,
    NUMBER,
    SPACES,
    Lines,
    content,
    decimal_comma,
    fields_of,
    is_value,
    plain_line,
)
from storage.formats.logger.units import quantity_of

if TYPE_CHECKING:
    import pandas as pd


HEAD = 200  # lines in which preamble and header end
COMMENTS = ("#", "%", "//", "!")
SEPARATORS = ("\t", ";", ",", "|", SPACES)
COMMA = re.compile(r"[-+]?\d*,\d+([eE][-+]?\d+)?")
PAIR = re.compile(r"([A-Za-z_][\w.]*)\s*[:=]\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)")
EMPTY = ("", "nan", "null", "na", "n/a", "none", "-")  # of a column that holds nothing
RUN = 4  # rows of numbers one after the other that begin the data
LISTED = 3  # rows named of a kind of fault
FEW = 0.01  # of the rows: as many cells without a number are left out, more are a fault


@dataclass
class Sheet:
    """The columns of a table as they were written.

    lines: of the file, of the rows of the frame. preamble: what stands before the header; begun:
    lines in which that stands again. notes: what was left out. faults: what makes rows unusable.
    """

    path: Path
    names: list[str]
    units: list[str]
    frame: "pd.DataFrame"
    lines: np.ndarray
    preamble: str = ""
    named: bool = True
    begun: tuple[int, ...] = ()
    notes: list[str] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)

    def text(self, column: int) -> "pd.Series":
        """A column as text, empty where there is nothing."""
        return self.frame.iloc[:, column].astype(object).fillna("").astype(str).str.strip()

    def is_numeric(self, column: int) -> bool:
        """Whether all of a column was read as numbers."""
        return bool(self.frame.dtypes.iloc[column].kind in "iuf")

    def numbers(self, column: int) -> np.ndarray:
        """A column (n,) as float64, NaN where it holds no number: of few rows a note, of more a
        fault, unless it is empty as a whole.
        """
        import pandas as pd

        series = self.frame.iloc[:, column]
        if self.is_numeric(column):
            values = np.asarray(series.to_numpy(float))
            return self._without_gaps(column, values)
        text = self.text(column)
        if text.str.fullmatch(COMMA.pattern + r"|[-+]?\d+|").all():
            text = text.str.replace(",", ".", regex=False)
        values = pd.to_numeric(text, errors="coerce").to_numpy(float)
        return self._without_gaps(column, values)

    def _without_gaps(self, column: int, values: np.ndarray) -> np.ndarray:
        wrong = ~np.isfinite(values)
        if not wrong.any():
            return values
        text = self.text(column)
        if wrong.all() and text.str.lower().isin(EMPTY).all():
            return values
        shown = ", ".join(
            f"line {self.lines[row]}: {text.iloc[row][:30]!r}"
            for row in np.flatnonzero(wrong)[:LISTED]
        )
        what = f"column {self.names[column]}: {int(wrong.sum())} of {len(wrong)} values are no "
        if wrong.mean() > FEW:
            self.faults.append(f"{what}numbers ({shown}); correct or remove these rows")
        else:
            self.notes.append(f"{what}numbers ({shown}); left out")
        return np.where(wrong, np.nan, values)


def read_sheet(path: Path) -> Sheet:
    """Reads a table of a kind in `tables`; raises Unusable for what holds no table of numbers."""
    with _as_unusable(path):
        found = content(path)
        if isinstance(found, Lines):
            return _of_lines(path, found.lines, found.separator)
        return _of_frame(path, found)


def read_protocol(path: Path) -> Sheet:
    """A table whose first line that is no comment names its columns, every value as text."""
    import pandas as pd

    with _as_unusable(path):
        found = content(path)
    if not isinstance(found, Lines):
        return _of_frame(path, found)
    kept = [(n, line) for n, line in enumerate(found.lines, start=1) if line.strip()]
    kept = [(n, line) for n, line in kept if not line.lower().startswith(("sep=", *COMMENTS))]
    if len(kept) < 2:
        raise Unusable(f"{path} holds no line below its header; write one for each position.")
    header = kept[0][1]
    separator = next((sign for sign in SEPARATORS[:4] if sign in header), SPACES)
    names = [name.strip('" ') for name in fields_of(header, separator)]
    rows = [_bare(fields_of(line, separator), len(names)) for _, line in kept[1:]]
    frame = pd.DataFrame(rows, columns=range(len(names)), dtype=str)
    return Sheet(path, names, [""] * len(names), frame, np.array([n for n, _ in kept[1:]]))


@contextmanager
def _as_unusable(path: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        raise Unusable(f"{path} cannot be read as a table ({reason}); export it again.") from error


def _of_frame(path: Path, frame: "pd.DataFrame") -> Sheet:
    if not len(frame):
        raise Unusable(f"{path} has no row of data; export it again.")
    names = [str(name) for name in frame.columns]
    return Sheet(path, names, [""] * len(names), frame, np.arange(1, len(frame) + 1))


def _of_lines(path: Path, lines: list[str], separator: str | None = None) -> Sheet:
    written = [(number, line.rstrip("\r\n")) for number, line in enumerate(lines, start=1)]
    written = [(n, line) for n, line in written if line.strip() and line[:4].lower() != "sep="]
    kept = [(n, plain_line(line)) for n, line in written]
    start, separator = _begin(path, [line for _, line in kept[:HEAD]], separator)
    data = [(n, line) for n, line in kept[start:] if not line.lstrip().startswith(COMMENTS)]
    count = _usual_count([line for _, line in data[:HEAD]], separator)
    before = [line for _, line in kept[:start]]
    _check_commas(path, before, separator, count)
    again = [n for n, line in data if line in before]
    data = [(n, line) for n, line in data if line not in before]
    names, units, preamble = _header(before, separator, count)
    pairs = PAIR.findall(kept[start][1].replace("\t", " "))
    if not names and len(pairs) >= LISTED:  # ax:0.1, ay:0.2: each row names its values
        names = [name for name, _ in pairs]
        data = [(n, ";".join(v for _, v in PAIR.findall(line))) for n, line in data]
        separator, count, units = ";", len(names), [""] * len(names)
    sheet = Sheet(path, names or [str(k + 1) for k in range(count)], units, _empty(), np.empty(0))
    sheet.preamble, sheet.named, sheet.begun = preamble, bool(names), tuple(again)
    if again:
        sheet.notes.append(f"the header stands again in line {again[0]}: left out")
    data = _even(sheet, data, separator, count)
    if len(data) < 2:
        raise Unusable(f"{path} has {len(data) or 'no'} row of data; export it again.")
    sheet.frame = _frame([line for _, line in data], separator, count)
    sheet.lines = np.array([number for number, _ in data])
    return sheet


def _empty() -> "pd.DataFrame":
    import pandas as pd

    return pd.DataFrame()


def _begin(path: Path, head: list[str], given: str | None) -> tuple[int, str]:
    """The first line of data and the separator: most numbers in a row, again and again."""
    best = (0, 0, "")
    for separator in SEPARATORS if given is None else (given,):
        rows = [fields_of(line, separator) for line in head]
        counts = [sum(map(is_value, row)) if len(row) > 1 else 0 for row in rows]
        every = zip(counts, rows, strict=True)
        values = [n if n >= 2 and n >= 0.5 * sum(map(bool, row)) else 0 for n, row in every]
        if not any(values):
            continue
        usual = int(np.median([n for n in values if n]))
        enough = [
            n > 0 and n >= 0.7 * min(usual, sum(map(bool, row)) if len(row) >= usual else usual)
            for n, row in zip(values, rows, strict=True)
        ]
        starts = (k for k in range(len(enough)) if all(enough[k : k + RUN]))
        first = next(starts, enough.index(True))
        if separator == "," and best[0] and usual > best[0] and decimal_comma(head[first:]):
            continue
        if usual > best[0]:
            best = (usual, first, separator)
    if not best[0]:
        pairs = [k for k, line in enumerate(head) if len(PAIR.findall(line)) >= LISTED]
        if pairs:
            return pairs[0], SPACES
        raise Unusable(
            f"{path}: no line of the first {len(head)} holds numbers side by side; give a table "
            "with a row for each sample."
        )
    return best[1], best[2]


def _check_commas(path: Path, before: list[str], separator: str, count: int) -> None:
    """Raises Unusable where every number stands in two fields, with the comma between them."""
    named = len(fields_of(before[-1], separator)) if before else 0
    if separator == "," and named > 1 and count in (2 * named - 1, 2 * named):
        raise Unusable(
            f"{path}: rows have {count} fields below a header of {named}: commas in numbers and "
            "between them; export it with semicolons or tabs between, or with decimal points."
        )


def _usual_count(lines: list[str], separator: str) -> int:
    return int(np.median([len(fields_of(line, separator)) for line in lines]))


def _header(before: list[str], separator: str, count: int) -> tuple[list[str], list[str], str]:
    """Names, units and preamble by the lines before the data; no names where no line has them."""
    rows = [[f.strip('" ') for f in fields_of(_uncommented(line), separator)] for line in before]
    if separator == SPACES and rows and len(rows[-1]) != count:  # names with spaces in them
        rows = [re.split(r"\t|;|,|\s{2,}", _uncommented(line).strip()) for line in before]
    fit = [k for k, row in enumerate(rows) if _fits(row, count)]
    if not fit or fit[-1] < len(rows) - 2:
        return [], [""] * count, "\n".join(before)
    place, units = fit[-1], [""] * count
    if place and place - 1 in fit and _are_units(rows[place]):
        units, place = _bare(rows[place], count), place - 1
    names = ["time" if CLOCK.fullmatch(name) else name for name in _bare(rows[place], count)]
    return names, units, "\n".join(before[:place])


def _uncommented(line: str) -> str:
    return line.lstrip().lstrip("".join(COMMENTS)).lstrip() if line.lstrip()[:1] in "#%/!" else line


def _fits(row: list[str], count: int) -> bool:
    return abs(len([cell for cell in row if cell]) - count) <= 1 and len(row) >= 2


def _are_units(row: list[str]) -> bool:
    cells = [cell.strip("[]()") for cell in row if cell.strip("[]() -")]
    return bool(cells) and sum(quantity_of(cell) is not None for cell in cells) > 0.6 * len(cells)


def _bare(row: list[str], count: int) -> list[str]:
    return (row + [""] * count)[:count]


def _even(sheet: Sheet, data: list[tuple[int, str]], separator: str, count: int) -> list:
    """The rows with as many fields as there are names; a last row cut off is left out."""
    if separator == SPACES:
        counts = np.array([len(line.split()) for _, line in data])
    elif any('"' in line for _, line in data[:HEAD]):
        return data
    else:
        counts = np.array([line.count(separator) + 1 for _, line in data])
    if counts[-1] < count and len(data) > 1:
        sheet.notes.append(f"line {data[-1][0]}, the last, is cut off: left out")
        data, counts = data[:-1], counts[:-1]
    wrong = np.flatnonzero(counts != count)
    if len(wrong):
        shown = ", ".join(f"line {data[k][0]}: {counts[k]}" for k in wrong[:LISTED])
        sheet.faults.append(
            f"{len(wrong)} of {len(data)} rows do not have the usual {count} fields ({shown}); "
            "correct or remove them"
        )
        data = [row for row, n in zip(data, counts, strict=True) if n == count]
    return data


def _frame(lines: list[str], separator: str, count: int) -> "pd.DataFrame":
    import pandas as pd

    cells = [cell for line in lines[:HEAD] for cell in fields_of(line, separator)]
    commas = sum(bool(COMMA.fullmatch(cell)) for cell in cells)
    decimal = "," if commas and not any("." in c for c in cells if NUMBER.fullmatch(c)) else "."
    return pd.read_csv(
        StringIO("\n".join(lines)),
        sep=separator,
        decimal=decimal,
        header=None,
        names=range(count),
        index_col=False,
        skipinitialspace=True,
        skip_blank_lines=True,
        na_values=["", "nan", "NaN", "null", "NA", "N/A"],
        keep_default_na=False,
        low_memory=False,
    )
