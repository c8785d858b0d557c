"""The kinds of file that a table comes in: one module for each, found by its SUFFIXES.

A module has `SUFFIXES`, in lower case and with their dots, and `read(path)`, which gives `Lines` or
a DataFrame. Reading one more kind of file is adding one module.
"""

import csv
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, TypeAlias

from schemas.base import Unusable

if TYPE_CHECKING:
    import pandas as pd


TEXT = ".txt"


@dataclass(frozen=True)
class Lines:
    """A table as lines of text. separator: of their fields; None where that is to be found."""

    lines: list[str]
    separator: str | None = None


Content: TypeAlias = "Lines | pd.DataFrame"


@cache
def readers() -> dict[str, Any]:
    """The modules by their suffixes."""
    modules = [import_module(f"{__name__}.{module.name}") for module in iter_modules(__path__)]
    return {suffix: module for module in modules for suffix in module.SUFFIXES}


def content(path: Path) -> Content:
    """What a file holds; of a suffix that nobody knows, as text.

    Raises Unusable, OSError or ValueError for what cannot be read.
    """
    found: Content = readers().get(path.suffix.lower(), readers()[TEXT]).read(path)
    return found


# The lines of a text file, and the fields and values in them.

ENCODINGS = ("utf-8-sig", "gb18030")  # then that of Western Windows
SPACES = r"\s+"
NUMBER = re.compile(r"[-+]?(\d+([.,]\d*)?|[.,]\d+)([eE][-+]?\d+)?|nan|inf|-inf", re.IGNORECASE)
CLOCK = re.compile(r"(\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}[T ]?)?(\d{1,2}:)?\d{1,2}:\d{2}\S*Z?")
DAY = re.compile(r"\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}")
MONITOR = " -> "  # between the serial monitor's clock and the line


def joined(cells: Sequence[str]) -> str:
    return "\t".join(cell.replace("\t", " ").replace("\n", " ") for cell in cells)


def decoded(path: Path) -> str:
    content = path.read_bytes()
    if not content:
        raise Unusable(f"{path} is empty; export it again.")
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16")
    if b"\0" in content[:4096]:
        raise Unusable(f"{path} is not text; give csv, tsv, xlsx or parquet.")
    for encoding in ENCODINGS:
        with suppress(UnicodeDecodeError):
            return content.decode(encoding)
    return content.decode("cp1252", errors="replace")


def plain_line(line: str) -> str:
    """A line of a serial monitor has its clock as a first field."""
    clock, arrow, rest = line.partition(MONITOR)
    if not arrow:
        return line
    return clock + next((sign for sign in "\t;," if sign in rest), " ") + rest


def fields_of(line: str, separator: str) -> list[str]:
    if separator == SPACES:
        return line.split()
    if '"' in line:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]
    return [cell.strip() for cell in line.split(separator)]


def is_value(text: str) -> bool:
    return bool(NUMBER.fullmatch(text) or CLOCK.fullmatch(text) or DAY.fullmatch(text))


def decimal_comma(lines: list[str]) -> bool:
    """Whether the fields between semicolons, tabs or spaces are numbers with a comma."""
    for separator in ("\t", ";", SPACES):
        fields = [cell for line in lines[:20] for cell in fields_of(line, separator)]
        if len(fields) > len(lines[:20]) and all(map(is_value, filter(None, fields))):
            return True
    return False
