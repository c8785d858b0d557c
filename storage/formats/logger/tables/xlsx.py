"""The cells of a workbook (Office Open XML, ECMA-376), as text, by the standard library."""

import re
import zipfile
from collections.abc import Iterator
from datetime import datetime, timedelta
from pathlib import Path
from xml.etree import ElementTree

from schemas.base import Unusable
from storage.formats.logger.tables import Lines, joined

SUFFIXES = (".xlsx", ".xlsm")
MAX_BYTES = 2**30  # of a sheet unpacked: more is no table of a logger
DAY_ZERO = datetime(1899, 12, 30)  # of Excel's days, after its 29 February 1900
DATES = {*range(14, 23), *range(45, 48)}  # built-in formats of dates and times
DATE_LETTERS = re.compile(r"[ydhs]", re.IGNORECASE)
QUOTED = re.compile(r'"[^"]*"|\[[^\]]*\]|\\.')


def read(path: Path) -> Lines:
    """A line for each row of the first sheet that holds a table, tabs between its cells."""
    return Lines([joined(cells) for cells in _rows(path)], "\t")


def _rows(path: Path) -> list[list[str]]:
    """The rows of the first sheet with more than one cell in a row; dates as ISO 8601.

    Raises Unusable for what is no workbook.
    """
    try:
        with zipfile.ZipFile(path) as book:
            if any(one.file_size > MAX_BYTES for one in book.infolist()):
                raise Unusable(f"{path} unpacks to more than 1 GB; export it as CSV or Parquet.")
            texts = [_text(one) for one in _parts(book, "xl/sharedStrings.xml", "si")]
            dates = _date_styles(book)
            names = sorted(
                (name for name in book.namelist() if name.startswith("xl/worksheets/sheet")),
                key=lambda name: (len(name), name),
            )
            for name in names:
                rows = [_cells(row, texts, dates) for row in _parts(book, name, "row")]
                if any(len(row) > 1 for row in rows):
                    return rows
    except (zipfile.BadZipFile, KeyError, ValueError, ElementTree.ParseError) as error:
        raise Unusable(
            f"{path} is no xlsx workbook ({error}); save it again, or as CSV."
        ) from error
    raise Unusable(f"{path}: no sheet holds a table; export it again.")


def _parts(book: zipfile.ZipFile, name: str, tag: str) -> Iterator[ElementTree.Element]:
    """The elements of a tag in a part of the book, one after the other; none of a missing part."""
    if name not in book.namelist():
        return
    with book.open(name) as file:
        for _, element in ElementTree.iterparse(file):
            if _tag(element) == tag:
                yield element
                element.clear()


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _text(element: ElementTree.Element) -> str:
    return "".join(part.text or "" for part in element.iter() if _tag(part) == "t")


def _date_styles(book: zipfile.ZipFile) -> set[int]:
    """The styles of cells that show a number as a date or a time."""
    formats, styles = dict[int, str](), set[int]()
    for tree in _parts(book, "xl/styles.xml", "styleSheet"):
        for one in tree.iter():
            if _tag(one) == "numFmt":
                formats[int(one.attrib["numFmtId"])] = one.attrib.get("formatCode", "")
        used = next((one for one in tree.iter() if _tag(one) == "cellXfs"), None)
        for number, one in enumerate(used if used is not None else ()):
            form = int(one.attrib.get("numFmtId", "0"))
            if form in DATES or DATE_LETTERS.search(QUOTED.sub("", formats.get(form, ""))):
                styles.add(number)
    return styles


def _cells(row: ElementTree.Element, texts: list[str], dates: set[int]) -> list[str]:
    cells: list[str] = []
    for cell in row:
        place = _column(cell.attrib.get("r", "")) if "r" in cell.attrib else len(cells)
        cells += [""] * (place - len(cells))
        cells.append(_value(cell, texts, dates))
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _column(reference: str) -> int:
    """The number of a column, from 0, by a reference such as AB12."""
    number = 0
    for letter in reference.rstrip("0123456789"):
        number = 26 * number + ord(letter) - ord("A") + 1
    return number - 1


def _value(cell: ElementTree.Element, texts: list[str], dates: set[int]) -> str:
    kind = cell.attrib.get("t", "n")
    if kind == "inlineStr":
        return _text(cell)
    value = next((part.text or "" for part in cell if _tag(part) == "v"), "")
    if kind == "s" and value:
        return texts[int(value)]
    if kind == "n" and value and int(cell.attrib.get("s", "0")) in dates:
        days = float(value)
        moment = (DAY_ZERO + timedelta(days=days)).isoformat(sep=" ", timespec="microseconds")
        return moment if days >= 1.0 else moment.split(" ")[1]
    return value
