"""Orders from text: the rows of a CSV file, and the lines of a barcode scanner."""

import csv
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from flows.orders import production
from schemas.base import Unusable
from schemas.certificate import Order
from schemas.orders import OrderRequest
from storage import settings
from storage.catalogue.orders import check_number
from storage.home import Home

COLUMNS = ("number", "station", "manufacturer", "model", "serial", "procedure", "client_order")
NEEDED = ("number", "station", "serial")
OF_UNIT = ("serial", "manufacturer", "model")
SCANNED = "SERIAL, or MANUFACTURER,MODEL,SERIAL[,PROCEDURE[,CLIENT_ORDER]]"


@dataclass(frozen=True)
class Rows:
    """The rows of one order, which follow each other: one for each unit. line: of the first."""

    line: int
    rows: tuple[Mapping[str, str], ...]


def read_orders(path: Path, person: str, home: Home) -> tuple[list[OrderRequest], list[str]]:
    """The orders of a CSV file, and every fault in it as a sentence.

    person: who orders. Raises Unusable for a file that cannot be read as such.
    """
    requests, faults = [], []
    for each in _grouped(_lines(path)):
        try:
            request = _request(each, path.parent)
            order = production.checked(request, person, home)
            check_number(order, home)
        except _ColumnError as fault:
            faults.append(f"{path} line {each.line}, column {fault}")
        except Unusable as fault:
            faults.append(f"{path} line {each.line}: {fault}")
        else:
            requests.append(request)
    return requests, faults + _twice(path, requests)


class _ColumnError(Exception):
    """What is wrong in a column, with its name and value."""


def _lines(path: Path) -> list[tuple[int, dict[str, str]]]:
    """Line number and fields of each row that is not empty."""
    reader = csv.DictReader(
        settings.text_of(path).splitlines(keepends=True), restkey="", strict=True
    )
    try:
        names = [name.strip() for name in reader.fieldnames or ()]
        unknown = [name for name in names if name not in COLUMNS]
        missing = [name for name in NEEDED if name not in names]
        twice = [name for name in names if names.count(name) > 1]
        for what, which in (
            ("has no", missing),
            ("has an unknown", unknown),
            ("names twice the", twice),
        ):
            if which:
                raise Unusable(
                    f"{path} line 1 {what} column {which[0]!r}: the columns are "
                    f"{', '.join(COLUMNS)}, with commas between them"
                )
        reader.fieldnames = names
        return [
            (reader.line_num, _stripped(path, reader.line_num, row))
            for row in reader
            if any(row.values())
        ]
    except csv.Error as error:
        raise Unusable(f"{path} line {reader.line_num}: {error}; save it as CSV.") from error


def _stripped(path: Path, line: int, row: Mapping[str, Any]) -> dict[str, str]:
    if "" in row:
        raise Unusable(f"{path} line {line} has more fields than line 1 has columns: quote a comma")
    return {name: (value or "").strip() for name, value in row.items()}


def _grouped(lines: Iterable[tuple[int, dict[str, str]]]) -> list[Rows]:
    """Rows with the same number that follow each other are the units of one order."""
    found: list[Rows] = []
    for line, row in lines:
        last = found[-1] if found else None
        if last and row["number"] and last.rows[0]["number"] == row["number"]:
            found[-1] = Rows(last.line, (*last.rows, row))
        else:
            found.append(Rows(line, (row,)))
    return found


def _request(order: Rows, folder: Path) -> OrderRequest:
    """The order of some rows; raises _ColumnError for the first that is wrong in them."""
    first = order.rows[0]
    for row in order.rows[1:]:
        for name in COLUMNS:
            if name not in OF_UNIT and row.get(name) != first.get(name):
                raise _ColumnError(
                    f"{name}: the rows of order {first['number']} have {first[name]!r} and "
                    f"{row[name]!r}; give each order another number"
                )
    if not first["number"]:
        raise _ColumnError("number: '' is empty; give each order a number of its own")
    try:
        client = client_order_named(first.get("client_order", ""), folder)
    except Unusable as fault:
        raise _ColumnError(f"client_order: {fault}") from fault
    fields = {name: first[name] for name in ("number", "station", "procedure") if first.get(name)}
    units = [{name: row[name] for name in OF_UNIT if row.get(name)} for row in order.rows]
    try:
        return OrderRequest.model_validate(fields | {"units": units, "client_order": client})
    except ValidationError as error:
        raise _ColumnError(_fault(error)) from error


def request_of(**fields: Any) -> OrderRequest:
    """The order with these fields; raises Unusable, named by the option, for one that is wrong."""
    try:
        return OrderRequest(**fields)
    except ValidationError as error:
        raise Unusable(f"--{_fault(error).replace('_', '-', 1)}") from error


def _fault(error: ValidationError) -> str:
    """Column, value and what is wrong, of the first fault."""
    fault = error.errors(include_url=False)[0]
    if fault["type"] == "missing":
        return f"{fault['loc'][-1]}: is empty"
    return f"{fault['loc'][-1]}: {fault['input']!r} has signs that no name has, or is too long"


def _twice(path: Path, requests: Sequence[OrderRequest]) -> list[str]:
    """Numbers that stand apart in the file, and so are of two orders."""
    numbers = [request.number for request in requests]
    again = sorted({str(number) for number in numbers if numbers.count(number) > 1})
    return [f"{path}, column number: {number!r} is of two orders" for number in again]


def client_order_named(name: str, folder: Path) -> Order | None:
    """A client's order by its file, as seen from a folder; None without a name."""
    return settings.read(folder / name, Order) if name else None


def scanned(line: str, station: str, home: Home) -> OrderRequest:
    """The order of a scanner's line; raises Unusable, with the forms there are, for another."""
    fields = [field.strip() for field in line.split(",")]
    if len(fields) == 2 or len(fields) > 5:
        raise Unusable(f"{line.strip()!r} is no order: scan {SCANNED}")
    serial, manufacturer, model = fields[0], None, None
    if len(fields) > 1:
        manufacturer, model, serial = fields[:3]
    more = dict(zip(("procedure", "client_order"), fields[3:], strict=False))
    given: dict[str, Any] = {
        "station": station,
        "units": [{"serial": serial, "manufacturer": manufacturer, "model": model}],
        "client_order": client_order_named(
            more.pop("client_order", ""), production.client_order_folder(home)
        ),
    }
    try:
        return OrderRequest.model_validate(given | {k: text for k, text in more.items() if text})
    except ValidationError as error:
        raise Unusable(f"{line.strip()!r} is no order ({_fault(error)}): scan {SCANNED}") from error
