"""The catalogue as contents of a backup's folder, and a catalogue from them."""

import hashlib
from collections.abc import Iterator
from pathlib import Path

import sqlalchemy as sql
import zstandard

from schemas.backup import KeptTable
from schemas.base import Unusable
from storage.backup.objects import Objects
from storage.catalogue import database, dump

LEVEL = 3  # of compression: documents shrink to a tenth, faster than a disk takes them


def copied(connection: sql.Connection, objects: Objects) -> tuple[KeptTable, ...]:
    """Keeps every table of a transaction's catalogue, of whatever revision."""
    return tuple(_copied(connection, table, objects) for table in dump.tables_of(connection))


def _copied(connection: sql.Connection, table: sql.Table, objects: Objects) -> KeptTable:
    rows, digest = 0, hashlib.sha256()

    def write(draft: Path) -> None:
        nonlocal rows
        packer = zstandard.ZstdCompressor(level=LEVEL)
        with draft.open("wb") as file, packer.stream_writer(file) as packed:
            for line in dump.lines(connection, table):
                packed.write(line)
                digest.update(line)
                rows += 1

    kept = objects.add(write)
    return KeptTable(
        name=table.name, columns=dump.columns_of(table), rows=rows, lines=digest.hexdigest(),
        object=kept,
    )  # fmt: skip


def lines_of(table: KeptTable, objects: Objects) -> Iterator[bytes]:
    """The rows of a kept table."""
    with objects.path(table.object).open("rb") as file:
        unpacked, rest = zstandard.ZstdDecompressor().read_to_iter(file), b""
        for part in unpacked:
            *whole, rest = (rest + part).split(b"\n")
            yield from (line + b"\n" for line in whole)


def make(
    connection: sql.Connection, kept: tuple[KeptTable, ...], revision: str, objects: Objects
) -> None:
    """Makes a catalogue of a revision in an empty database, and fills it.

    Raises Unusable where it then does not hold what was kept.
    """
    database.bring_to(connection, revision)
    tables, of_name = dump.tables_of(connection), {each.name: each for each in kept}
    if {table.name for table in tables} != of_name.keys():
        named = ", ".join(sorted({table.name for table in tables} ^ of_name.keys()))
        raise Unusable(f"The backup has other tables than revision {revision} ({named}).")
    pointing = []
    for table in tables:
        each = of_name[table.name]
        rows = lines_of(each, objects)
        pointing.append((table, list(dump.load(connection, table, each.columns, rows))))
    for table, rows_of_table in pointing:
        dump.point(connection, table, rows_of_table)
    dump.count_on(connection, tables)
    for table in tables:
        digest = hashlib.sha256()
        for line in dump.lines(connection, table):
            digest.update(line)
        if digest.hexdigest() != of_name[table.name].lines:
            raise Unusable(
                f"The table {table.name} does not hold what the backup has; nothing was restored. "
                "Restore an earlier backup with --backup."
            )
