"""The lines of a text file, and the fields and values in them."""

import csv
import re
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from schemas.base import Unusable

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
